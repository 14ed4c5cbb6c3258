// Digitised trees as MTG text (mtg_text.h says what that is), such as those measured with an electromagnetic pointer:
// Sinoquet, Godin and Rivet, Silva Fennica 31(3), 1997.
//
// Columns used: XX YY ZZ (position of an element's upper end; ZZ up), TopDia (diameter there) and a leaf count. An element
// begins at the upper end of the one it follows or branches off. The position of an entity that has parts, such as an axis, is
// where its first part begins; wood of that diameter joins it to its bearer.
//
// Mended, and counted in the notes:
//   no position           left out, and what it bears hangs on the element before; placed evenly between its neighbours on the
//                         axis when something branches off it
//   no length             joined with the element it stands on
//   no diameter           from what it bears by the pipe model (the cross-sections' sum), never thicker than what bears it
//   negative leaf count   taken for missing
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/result.h"
#include "structure/tree/imported_tree.h"

namespace roseau::structure {

struct MtgOptions {
  double length_unit_m = 0.01;     // of XX, YY and ZZ: centimetres
  double diameter_unit_m = 0.001;  // of TopDia: millimetres
  double tip_radius_m = 0.002;     // of tips without a diameter, where their bearer is not thinner

  /// The column with the number of leaves on an element; a file without it, or an empty name: no leaves.
  std::string leaf_count_column = "NFe";
  /// A compound leaf counts as one blade: these are a walnut's.
  double leaf_length_m = 0.24;
  double leaf_width_m = 0.09;
  std::uint64_t leaf_seed = 1;  // digitised trees say how many leaves an element has, not how they hang
};

/// Takes the units of an AMAPmod dressing file (.drf) over: "LengthUnit = n" and "DiameterUnit = n" say how many of the file's
/// steps make one unit of `options.length_unit_m` as it was before. Other keys concern drawing. Error (corrupt): names the
/// line.
Result<void> apply_dressing(std::string_view text, const std::string& source_name, MtgOptions& options);

/// Errors (invalid_argument: options; corrupt, unsupported: names source and line): see mtg_text.h; no coordinates; a single
/// point; an element that comes back, by name and position, on its own axis (a loop); an element more than 500 m from the foot
/// or thicker than 20 m, which says that the units are wrong.
Result<ImportedTree> read_mtg(std::string_view text, const std::string& source_name, const MtgOptions& options = {});

}  // namespace roseau::structure
