// Any bytes as a session file, read, verified and recovered: no crash, no hang, no memory beyond what the bytes can justify.
// What recovery writes must be whole, whatever it was made from, and recovering that must change nothing.
#include <cstdint>
#include <span>
#include <vector>

#include "core/check.h"
#include "recorder/tools/inspect/verification.h"
#include "recorder/tools/recover/recovery.h"
#include "tests/support/exercise_mcap.h"

namespace {

using namespace roseau;

const mcap::ReaderOptions kSmall{.max_chunk_bytes = 1U << 24U};

void recover(const std::vector<std::byte>& file) {
  testing::MemoryReadable in(file);
  testing::MemoryWritable once;
  const auto recovery = recorder::recover_session(in, once, {.progress = {}, .reader = kSmall});
  if (!recovery) return;
  testing::MemoryReadable recovered(once.bytes);
  const auto read = testing::exercise_mcap(once.bytes);
  ROSEAU_CHECK(read.errors == 0 && read.streamed_messages == recovery->messages && read.indexed_messages == recovery->messages);
  testing::MemoryWritable twice;
  const auto again = recorder::recover_session(recovered, twice, {.progress = {}, .reader = kSmall});
  ROSEAU_CHECK(again && again->was_whole && twice.bytes == once.bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The magic is given, so that the fuzzer need not find it; the tests check what happens without it.
  std::vector<std::byte> file(mcap::kMagic.begin(), mcap::kMagic.end());
  const auto rest = std::as_bytes(std::span(data, size));
  file.insert(file.end(), rest.begin(), rest.end());
  static_cast<void>(testing::exercise_mcap(file));
  testing::MemoryReadable in(file);
  static_cast<void>(recorder::verify_session(in, {.progress = {}, .reader = kSmall}).has_value());
  recover(file);
  return 0;
}
