// SimulatedTruth: what the scene knows and no instrument tells, as streams beside those of the instruments.
//
//   /truth/wind                                    air at the branch, in the sonic's axes               wind_rate_hz
//   /truth/sonic/wind                              air at the sonic, without its noise and rounding     wind_rate_hz
//   /truth/cameraN/target/branch/displacement      of the target, from rest, at each frame's midpoint   the camera's rate
//   /truth/cameraN/target/branch/force             force per mass (px / s^2) and the wind along the axis that drives it
//   /truth/target/branch/identification            true natural frequency and damping ratio             every 10 s
//
// All arrive at their sample time.
#pragma once

#include <memory>
#include <vector>

#include "synthesis/rig/simulated_device.h"
#include "synthesis/rig/world.h"

namespace roseau::synthesis {

class SimulatedTruth final : public SimulatedDevice {
 public:
  explicit SimulatedTruth(std::shared_ptr<const World> world);

  const std::string& name() const override { return name_; }
  void declare(StreamTable& streams) override;
  Due next() const override;
  bool produce(HostTime start, SampleSink& sink) override;
  /// Truth is never lost.
  void lose_before(Duration) override {}
  void lose_next() override {}

 private:
  // A row of samples at a steady rate.
  struct Series {
    enum class What : std::uint8_t { identification, wind, camera };
    What what;
    std::size_t camera;
    SampleTimes times;
    std::uint64_t number = 0;
    std::vector<StreamId> streams = {};

    double next_s() const { return times.sample_time_s(number); }
  };

  const Series& next_series() const;
  void emit(const Series& series, HostTime time, SampleSink& sink);
  Displacement displacement(std::size_t camera, double deflection_m) const;
  WindEstimate force(std::size_t camera, double time_s) const;
  Identification identification() const;

  std::shared_ptr<const World> world_;
  std::string name_ = "truth";
  BranchMotion branch_;
  std::vector<Series> series_;
};

}  // namespace roseau::synthesis
