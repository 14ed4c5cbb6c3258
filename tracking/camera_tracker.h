// CameraTracker: the tracking stage of one camera. From its frames it derives
//
//   /camera0/motion                        ImageMotion    once per frame: points and targets, for showing
//   /camera0/target/<name>/displacement    Displacement   once per frame and target
//
// and it obeys OperatorAction samples that add or remove a target of this camera. A target's displacement is zero in the
// frame after it was given, in pixels, to the right and down, with the camera's own motion (seen by background points)
// taken off. Method, figures and limits: docs/tracking.md.
//
// Pure and deterministic: no clock, no thread of its own, nothing random; the number of OpenCV's threads does not matter.
// Used by one thread at a time. Different cameras' trackers share nothing.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/log.h"
#include "core/result.h"
#include "core/stage.h"
#include "core/stream.h"
#include "tracking/automatic_targets.h"
#include "tracking/flow.h"
#include "tracking/gray.h"
#include "tracking/options.h"
#include "tracking/region_tracker.h"

namespace roseau::tracking {

class CameraTracker final : public Stage {
 public:
  /// `camera` is the device's name ("camera0"); its frames come on "/camera0/image". CHECKs that validate(options) holds.
  CameraTracker(StreamTable& streams, std::string camera, TrackerOptions options);

  /// A frame that is late or repeated is ignored; one that is incomplete or unusable gives the last displacements, not
  /// valid. A frame of another size starts everything anew.
  void process(const Sample& input, SampleSink& out) override;

  /// Appends the whole state: a tracker of the same camera and options that load()s it continues with the same bits.
  void save(std::vector<std::byte>& out) const;
  /// Replaces the state. On an Error the tracker is as newly made.
  Result<void> load(std::span<const std::byte> in);

  const std::string& camera() const { return camera_; }
  /// For a benchmark. The observer must outlive the tracker or be taken off with nullptr.
  void observe_work(WorkObserver* observer);

 private:
  struct Output {
    StreamId stream = 0;
    std::uint32_t sequence = 0;
  };
  Output& output_of(const std::string& target);

  bool is_mine(const Sample& frame);
  void obey(const OperatorAction& action);
  void add_target(const TargetRegion& target);
  void remove_target(const std::string& name);

  void process_frame(const SampleHeader& header, const Frame& frame, SampleSink& out);
  bool analyse(const SampleHeader& header, const Frame& frame);
  void follow();
  void start_background();
  void start_pending();
  void retry_failed_starts();
  void choose_automatically();
  void restart();

  CameraMotion camera_motion() const;
  std::vector<ImageRect> target_regions() const;
  int background_share() const;
  int target_share() const;
  void complain(const SampleHeader& header, const std::string& message);

  void emit(const SampleHeader& header, bool usable, SampleSink& out);
  ImageMotion image_motion(bool usable) const;
  Displacement displacement_of(const RegionTracker& target, bool usable) const;

  void load_state(CheckpointReader& in);
  void enters(Work work) const {
    if (observer_ != nullptr) observer_->enters(work);
  }

  StreamTable& streams_;
  const std::string camera_;
  const TrackerOptions options_;
  std::optional<StreamId> image_stream_;
  Output motion_output_;
  std::map<std::string, Output> outputs_;  // per target name; kept when a target goes, so that its numbering goes on
  WorkObserver* observer_ = nullptr;

  GrayConverter converter_;
  cv::Mat gray_storage_;
  Flow flow_;
  std::vector<FlowPoint> points_;

  std::optional<RegionTracker> background_;
  std::vector<RegionTracker> targets_;
  std::vector<TargetRegion> pending_;  // to be started in the next frame; internal pixel coordinates
  std::optional<AutomaticTargets> automatic_;
  std::optional<HostTime> last_time_;
  std::uint32_t frames_ = 0;
  RateLimit complaints_{std::chrono::seconds(10)};
};

}  // namespace roseau::tracking
