// SimulatedTruth: what the scene knows and no instrument tells, as streams beside those of the instruments.
//
//   /truth/wind                                    air at the middle of the crown's drag, in the sonic's axes   wind_rate_hz
//   /truth/sonic/wind                              air at the sonic, without its faults, when it really measured
//   /truth/cameraN/exposure                        exposure midpoints, by frame number
//   /truth/cameraN/target/NAME/displacement        of the target, from rest, at each frame's midpoint
//   /truth/cameraN/target/NAME/force               force per mass (px / s^2): w0^2 times the displacement that the momentary
//   forces
//                                                  would hold; and the wind along the target's motion
//   /truth/target/NAME/identification              true natural frequency and damping ratio                     every 10 s
//   /truth/balls                                   marker paths, world frame                                    marker_rate_hz
//   /truth/bar_rig                                 the calibration rig's targets, world frame                   marker_rate_hz
//   /truth/tracker/stationN/pose                   where the station is, in the axes of the source, when it was really measured
//   /truth/DEVICE/clock                            offset (host - device) and frequency offset                 every second
//   /truth/tree                                    modes: frequencies, amplitudes, forces                       marker_rate_hz
//
// All arrive at their sample time.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "synthesis/instruments/simulated_device.h"
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
  using Send = std::function<void(StreamId, Payload)>;
  // Samples of some streams at common times.
  struct Series {
    SampleTimes times;
    std::function<void(double time_s, const Send& send)> emit;
    std::uint64_t number = 0;
    double next_s() const { return times.sample_time_s(number); }
  };

  const Series& next_series() const;
  StreamId add(StreamTable& streams, std::string topic, SampleKind kind,
               std::map<std::string, std::string> metadata = {}) const;
  void add_winds(StreamTable& streams);
  void add_camera(StreamTable& streams, std::size_t camera);
  void add_identifications(StreamTable& streams);
  void add_markers(StreamTable& streams);
  void add_stations(StreamTable& streams);
  void add_clocks(StreamTable& streams);
  MarkerPositions balls(double time_s);
  ModalState modes(double time_s);
  WindEstimate force(const PlacedTarget& target, std::size_t camera, double time_s);

  std::shared_ptr<const World> world_;
  std::string name_ = "truth";
  std::vector<Series> series_;
  HostTime start_;              // of the scene, at the host
  Eigen::VectorXd amplitudes_;  // scratch
  Eigen::VectorXd forces_;
};

}  // namespace roseau::synthesis
