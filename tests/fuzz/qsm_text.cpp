// Any text is either a tree that keeps every rule of its kind, or an error with words.
#include "core/check.h"
#include "structure/tree/qsm.h"
#include "structure/tree/tree_check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto read = roseau::structure::read_qsm_text({reinterpret_cast<const char*>(data), size}, "fuzz");
  if (!read) {
    ROSEAU_CHECK(!read.error().message.empty());
  } else {
    ROSEAU_CHECK(roseau::structure::check(read->tree));
    ROSEAU_CHECK(read->placed_elements <= read->elements);
  }
  return 0;
}
