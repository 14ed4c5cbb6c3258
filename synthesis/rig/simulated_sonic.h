// SimulatedSonic: a Gill WindMaster on a serial line. Bytes as the real one would send them, through the real encoder.
#pragma once

#include <deque>
#include <memory>

#include "synthesis/rig/simulated_device.h"
#include "synthesis/rig/world.h"

namespace roseau::synthesis {

/// Stream: /sonic/raw.
class SimulatedSonic final : public SimulatedDevice {
 public:
  explicit SimulatedSonic(std::shared_ptr<const World> world);

  const std::string& name() const override { return name_; }
  void declare(StreamTable& streams) override;
  Due next() const override;
  bool produce(HostTime start, SampleSink& sink) override;
  /// A serial port's buffer outlasts any stall that we survive: nothing is lost.
  void lose_before(Duration) override {}
  void lose_next() override {}

 private:
  struct Piece {
    Duration arrival{0};
    RawBytes bytes;
  };

  const SonicScene& sonic() const { return world_->scene.sonic; }
  WindSample measure(std::uint64_t record) const;
  void send_next_record();
  void send_piece(std::span<const std::byte> bytes, Duration arrival);

  std::shared_ptr<const World> world_;
  std::string name_ = "sonic";
  SampleTimes times_;
  RandomStream noise_;
  RandomStream splits_;
  Duration byte_time_;

  StreamId stream_ = 0;
  std::uint64_t record_ = 0;
  std::uint64_t pieces_handed_on_ = 0;
  Duration line_free_{0};      // when the last byte sent is through
  std::deque<Piece> on_line_;  // never empty between calls
};

}  // namespace roseau::synthesis
