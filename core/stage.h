// Stage: one step of the analysis. A pure function of the ordered samples it is given and of its own state: no clock, no
// thread, no random number, no unordered iteration. The same samples in the same order give the same bits, live and in replay.
#pragma once

#include "core/sample.h"
#include "core/source.h"

namespace roseau {

class Stage {
 public:
  virtual ~Stage() = default;
  /// Sees every sample of the ordered stream, those it has no use for included; hands what it derives to `out`.
  /// Called by one thread at a time.
  virtual void process(const Sample& input, SampleSink& out) = 0;
};

}  // namespace roseau
