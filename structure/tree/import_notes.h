// Collects what a reader mended.
#pragma once

#include <utility>
#include <vector>

#include "structure/tree/imported_tree.h"

namespace roseau::structure {

class ImportNotes {
 public:
  void add(const char* what, std::size_t line) {
    for (auto& note : notes_) {
      if (note.what == what) {
        ++note.count;
        return;
      }
    }
    notes_.push_back({what, 1, line});
  }
  std::vector<ImportNote> take() { return std::move(notes_); }

 private:
  std::vector<ImportNote> notes_;  // in the order of first appearance
};

}  // namespace roseau::structure
