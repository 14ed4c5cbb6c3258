// Any text is either a tree that keeps every rule of its kind, or an error with words.
#include "structure/tree/mtg.h"

#include "core/check.h"
#include "structure/tree/mtg_text.h"
#include "structure/tree/tree_check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto read = roseau::structure::read_mtg(text, "fuzz");
  if (!read) {
    ROSEAU_CHECK(!read.error().message.empty());
  } else {
    ROSEAU_CHECK(roseau::structure::check(read->tree));
    ROSEAU_CHECK(read->placed_elements <= read->elements);
  }
  roseau::structure::MtgOptions options;
  const auto dressed = roseau::structure::apply_dressing(text, "fuzz", options);
  ROSEAU_CHECK(!dressed || (options.length_unit_m > 0 && options.diameter_unit_m > 0));
  return 0;
}
