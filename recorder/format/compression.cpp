#include "recorder/format/compression.h"

#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

namespace roseau::mcap {

namespace {

constexpr std::array<std::string_view, 3> kNames = {"", "zstd", "lz4"};
constexpr int kZstdLevel = 1;
constexpr std::size_t kFirstGrowth = std::size_t{1} << 20U;

struct ZstdDelete {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
  void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
};
struct Lz4Delete {
  void operator()(LZ4F_dctx* context) const { LZ4F_freeDecompressionContext(context); }
};

Error corrupt(std::string_view library, const char* what) {
  return {ErrorCode::corrupt, "compressed chunk: " + std::string(library) + ": " + what};
}

Error wrong_size(std::uint64_t expected_bytes) {
  return {ErrorCode::corrupt, "compressed chunk: does not hold the " + std::to_string(expected_bytes) + " bytes it announces"};
}

/// Calls `step(to, from)` until it says that it is done, giving it ever more room, but never more than expected.
/// step returns Result<bool>: true = the compressed stream has ended; it shortens both spans by what it used.
template <class Step>
Result<void> decompress_stream(std::span<const std::byte> bytes, std::uint64_t expected_bytes, std::vector<std::byte>& out,
                               Step step) {
  out.clear();
  std::uint64_t produced = 0;
  bool ended = false;
  while (!ended) {
    if (produced == out.size()) {
      const std::uint64_t room = std::max<std::uint64_t>(kFirstGrowth, 2 * produced);
      out.resize(std::min(expected_bytes, room));
    }
    std::span<std::byte> to = std::span(out).subspan(produced);
    const std::size_t room_before = to.size();
    const std::size_t input_before = bytes.size();
    auto done = step(to, bytes);
    if (!done) return done.error();
    ended = *done;
    produced += room_before - to.size();
    const bool stuck = room_before == to.size() && input_before == bytes.size();
    if (!ended && stuck) return wrong_size(expected_bytes);  // wants more input or more room than there is
  }
  if (produced != expected_bytes || !bytes.empty()) return wrong_size(expected_bytes);
  out.resize(produced);
  return {};
}

Result<void> decompress_zstd(std::span<const std::byte> bytes, std::uint64_t expected_bytes, std::vector<std::byte>& out) {
  const std::unique_ptr<ZSTD_DCtx, ZstdDelete> context(ZSTD_createDCtx());
  return decompress_stream(bytes, expected_bytes, out,
                           [&](std::span<std::byte>& to, std::span<const std::byte>& from) -> Result<bool> {
                             ZSTD_outBuffer output{to.data(), to.size(), 0};
                             ZSTD_inBuffer input{from.data(), from.size(), 0};
                             const std::size_t left = ZSTD_decompressStream(context.get(), &output, &input);
                             if (ZSTD_isError(left) != 0) return corrupt("zstd", ZSTD_getErrorName(left));
                             to = to.subspan(output.pos);
                             from = from.subspan(input.pos);
                             return left == 0;
                           });
}

Result<void> decompress_lz4(std::span<const std::byte> bytes, std::uint64_t expected_bytes, std::vector<std::byte>& out) {
  LZ4F_dctx* raw_context = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&raw_context, LZ4F_VERSION)) != 0) {
    return Error{ErrorCode::io, "lz4: no memory for a decompression context"};
  }
  const std::unique_ptr<LZ4F_dctx, Lz4Delete> context(raw_context);
  return decompress_stream(
      bytes, expected_bytes, out, [&](std::span<std::byte>& to, std::span<const std::byte>& from) -> Result<bool> {
        std::size_t written = to.size();
        std::size_t used = from.size();
        const std::size_t left = LZ4F_decompress(context.get(), to.data(), &written, from.data(), &used, nullptr);
        if (LZ4F_isError(left) != 0) return corrupt("lz4", LZ4F_getErrorName(left));
        to = to.subspan(written);
        from = from.subspan(used);
        return left == 0;
      });
}

Result<void> compress_zstd(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
  // One context per writing thread: making one costs more than compressing a small chunk.
  thread_local const std::unique_ptr<ZSTD_CCtx, ZstdDelete> context(ZSTD_createCCtx());
  out.resize(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compressCCtx(context.get(), out.data(), out.size(), bytes.data(), bytes.size(), kZstdLevel);
  if (ZSTD_isError(size) != 0) return Error{ErrorCode::io, std::string("zstd: ") + ZSTD_getErrorName(size)};
  out.resize(size);
  return {};
}

Result<void> compress_lz4(std::span<const std::byte> bytes, std::vector<std::byte>& out) {
  out.resize(LZ4F_compressFrameBound(bytes.size(), nullptr));
  const std::size_t size = LZ4F_compressFrame(out.data(), out.size(), bytes.data(), bytes.size(), nullptr);
  if (LZ4F_isError(size) != 0) return Error{ErrorCode::io, std::string("lz4: ") + LZ4F_getErrorName(size)};
  out.resize(size);
  return {};
}

}  // namespace

std::string_view to_string(Compression compression) { return kNames.at(static_cast<std::size_t>(compression)); }

std::optional<Compression> compression_from_string(std::string_view name) {
  const auto* found = std::ranges::find(kNames, name);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<Compression>(found - kNames.begin());
}

Result<void> compress(Compression compression, std::span<const std::byte> bytes, std::vector<std::byte>& out) {
  ROSEAU_CHECK(compression != Compression::none);
  return compression == Compression::zstd ? compress_zstd(bytes, out) : compress_lz4(bytes, out);
}

Result<void> decompress(Compression compression, std::span<const std::byte> bytes, std::uint64_t expected_bytes,
                        std::vector<std::byte>& out) {
  ROSEAU_CHECK(compression != Compression::none);
  return compression == Compression::zstd ? decompress_zstd(bytes, expected_bytes, out)
                                          : decompress_lz4(bytes, expected_bytes, out);
}

}  // namespace roseau::mcap
