// What tracking is busy with, for those who measure where the time goes. Observing changes no result.
#pragma once

#include <cstdint>

namespace roseau::tracking {

enum class Work : std::uint8_t { gray, pyramid, flow, patches, robust, renewal, output };

class WorkObserver {
 public:
  virtual ~WorkObserver() = default;
  virtual void enters(Work work) = 0;
};

}  // namespace roseau::tracking
