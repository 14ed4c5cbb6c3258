// MTG text ("multi-scale tree graph", FORM-A): which plant element grows out of which, at several scales. What is read here is
// the topology and the features as they stand; mtg.h makes a tree of them.
//
//   CODE:     FORM-A
//   CLASSES:  symbol, scale, ...          P 1, A 2, S 3: a plant of axes of segments
//   FEATURES: name, type
//   MTG:
//   ENTITY-CODE <tab> <tab> XX  YY  ...   the header: entity columns until the first feature
//   /P1                                   "/" is a part of, "<" follows on the same axis, "+" branches off
//   <tab>/A1/S1<S2                        belongs to the last entity one column to the left
//   <tab>^<S3<<S9                         "^": goes on from the last entity of its own column; "<<" stands for S4<S5<...<S9
//   <tab><tab>+A2/S1                      the features on a line are those of its last entity
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "structure/tree/imported_tree.h"

namespace roseau::structure {

struct MtgEntity {
  static constexpr std::int32_t kNone = -1;
  static constexpr std::int64_t kNoIndex = -1;

  std::size_t line = 0;
  std::int32_t symbol = 0;  // index into MtgText::symbols
  std::int64_t index = kNoIndex;
  char relation = '/';  // '/', '<' or '+': to `from`
  /// The entity this one grows out of, at the finest scale told so far; for the first part of an entity, that entity.
  std::int32_t from = kNone;
  std::int32_t whole = kNone;      // the entity of a coarser scale that this is a part of
  std::int32_t last_part = kNone;  // kNone: this one has no parts, it is an element of its own
  std::int32_t namesake = kNone;   // the first with the same label and whole; not for branches, whose numbers are free
  std::size_t stands_for = 1;      // entities, with those that "<<" leaves out
  std::vector<double> features;    // as asked for; NaN where blank
};

struct MtgText {
  struct Symbol {
    std::string name;
    int scale = 0;
  };
  std::vector<Symbol> symbols;
  std::vector<bool> has_column;     // per feature asked for
  std::vector<MtgEntity> entities;  // each after the one it grows out of
  std::vector<ImportNote> notes;

  std::string label(const MtgEntity& entity) const;  // "S12"
};

/// The entities of the file's first plant, with the named features. Errors (corrupt, unsupported) name source and line.
Result<MtgText> parse_mtg(std::string_view text, const std::string& source_name, const std::vector<std::string>& feature_names);

}  // namespace roseau::structure
