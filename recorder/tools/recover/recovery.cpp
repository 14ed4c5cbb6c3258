#include "recorder/tools/recover/recovery.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "recorder/format/file_index.h"
#include "recorder/format/file_io.h"
#include "recorder/tools/recover/recoverer.h"
#include "recorder/tools/recover/tail_file.h"

namespace roseau::recorder {

namespace {

/// Nothing of an unfinished output stays.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path path) : path_(std::move(path)) {}
  ~OutputFile() {
    std::error_code ignored;
    if (!kept_) std::filesystem::remove(path_, ignored);
  }
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  void keep() { kept_ = true; }

 private:
  std::filesystem::path path_;
  bool kept_ = false;
};

bool at_the_end(const LostStretch& stretch, std::uint64_t size) { return stretch.offset + stretch.bytes == size; }

Error named(const Error& error, const std::filesystem::path& path) {
  const bool says_it = error.message.find(path.string()) != std::string::npos || error.code == ErrorCode::no_space;
  return says_it ? error : Error{error.code, path.string() + " " + error.message};
}

}  // namespace

Result<Recovery> recover_session(mcap::Readable& in, mcap::Writable& out, const RecoverOptions& options) {
  return Recoverer(in, out, options).run();
}

Result<Recovery> recover_session(const std::filesystem::path& input, const std::filesystem::path& output,
                                 const RecoverOptions& options) {
  auto in = mcap::FileReadable::open(input);
  if (!in) return in.error();
  auto out = mcap::FileWritable::create(output);
  if (!out) return out.error();
  OutputFile unfinished(output);
  auto recovery = recover_session(**in, **out, options);
  if (!recovery) return named(recovery.error(), input);
  (*out)->begin_closing();
  if (auto closed = (*out)->close(); !closed) return closed.error();
  unfinished.keep();
  recovery->input = input;
  recovery->output = output;
  return recovery;
}

Result<Recovery> recover_in_place(const std::filesystem::path& path, const RecoverOptions& options) {
  auto file = TailFile::open(path);
  if (!file) return file.error();
  Recoverer recoverer(**file, **file, options);
  auto recovery = recoverer.run();
  if (!recovery) return named(recovery.error(), path);
  recovery->input = path;
  recovery->output = path;
  recovery->in_place = true;
  if (recovery->was_whole) {
    recovery->output_bytes = recovery->input_bytes;
    return recovery;
  }
  const std::uint64_t size = (*file)->size();
  const bool only_the_end = std::ranges::all_of(recovery->lost, [&](const auto& lost) { return at_the_end(lost, size); });
  if (!only_the_end || (*file)->kept_bytes() < recoverer.readable_end()) {
    return Error{ErrorCode::unsupported,
                 path.string() + " is damaged in front of its end, or was not written by roseau: recover it into a new file"};
  }
  auto torn = (*file)->commit();
  if (!torn) return torn.error();
  recovery->torn_bytes = std::move(*torn);
  return recovery;
}

Result<bool> ends_properly(const std::filesystem::path& path) {
  auto in = mcap::FileReadable::open(path);
  if (!in) return in.error();
  const auto ending = mcap::check_ending(**in);
  if (!ending && ending.error().code == ErrorCode::io) return ending.error();
  return ending.has_value();
}

}  // namespace roseau::recorder
