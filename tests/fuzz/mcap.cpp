// Any bytes as a session file: no crash, no hang, no memory beyond what the bytes can justify.
#include <cstdint>
#include <span>
#include <vector>

#include "tests/support/exercise_mcap.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  // The magic is given, so that the fuzzer need not find it; the tests check what happens without it.
  std::vector<std::byte> file(roseau::mcap::kMagic.begin(), roseau::mcap::kMagic.end());
  const auto rest = std::as_bytes(std::span(data, size));
  file.insert(file.end(), rest.begin(), rest.end());
  static_cast<void>(roseau::testing::exercise_mcap(file));
  return 0;
}
