#include "daemon/session.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "core/log.h"
#include "daemon/digest.h"
#include "daemon/health.h"
#include "daemon/host_clock.h"
#include "daemon/pipeline.h"
#include "daemon/progress.h"
#include "daemon/recording.h"
#include "daemon/service_manager.h"
#include "daemon/stop_signals.h"
#include "daemon/summary.h"
#include "daemon/version.h"
#include "display/server.h"
#include "drivers/wire/make_decoder.h"
#include "estimation/estimation_stage.h"
#include "tracking/camera_tracker.h"

namespace roseau::daemon {

namespace {

constexpr std::chrono::milliseconds kControlInterval{100};
constexpr Duration kHealthInterval = std::chrono::seconds(1);
// A page that is loaded again is gone for a moment: a replay at its end waits so long for somebody who watches.
constexpr Duration kViewerGrace = std::chrono::seconds(10);

std::vector<Analysis::Tracker> make_trackers(const SessionPlan& plan, StreamTable& streams) {
  std::vector<Analysis::Tracker> trackers;
  for (const auto& camera : plan.cameras) {
    tracking::TrackerOptions options = plan.config.tracking.options;
    for (const auto& target : plan.config.tracking.targets) {
      if (target.camera == camera) options.targets.push_back({target.name, target.region});
    }
    trackers.push_back({camera, std::make_unique<tracking::CameraTracker>(streams, camera, options)});
  }
  return trackers;
}

class Session {
 public:
  explicit Session(SessionPlan plan)
      : plan_(std::move(plan)),
        is_replay_(plan_.player != nullptr),
        utc_minus_host_time_(plan_.utc_minus_host_time.value_or(recorder::current_utc_minus_host_time())),
        results_(std::make_unique<ResultCollector>(streams_)),
        digest_(std::make_unique<Digest>()),
        recording_(streams_, recording_plan(), recording_callbacks()),
        pipeline_(
            pipeline_options(), streams_, wire::make_decoder, [this] { return make_stages(); }, hooks()),
        health_(streams_, pipeline_.counters(), pipeline_.supervisor(), recording_.recorder()) {}

  int run() {
    StopSignals signals;
    if (!is_replay_) signals.take_trigger();
    if (auto started = start_display(); !started) return fail(started.error());
    if (auto begun = recording_.begin(); !begun) return fail(begun.error());
    for (auto& source : plan_.sources) pipeline_.add_source(std::move(source));
    const HostTime begin = host_now();
    for (auto& action : plan_.first_actions) pipeline_.act(action, begin);
    run_threads(signals, begin);
    const double wall_s = to_seconds(host_now() - begin);
    notify_stopping();
    const auto closed = recording_.finish();
    if (display_) display_->stop();
    report(wall_s);
    if (!closed) return fail(closed.error());
    if (const auto failure = pipeline_.supervisor().first_failure(); !failure.empty()) {
      return fail(Error{ErrorCode::io, failure});
    }
    return kExitOk;
  }

 private:
  static int fail(const Error& error) {
    std::fputs(("roseau: " + error.message + "\n").c_str(), stderr);
    return kExitFailed;
  }

  RecordingPlan recording_plan() const {
    RecordingPlan plan;
    plan.config = plan_.config.recording;
    if (plan_.arguments.record) plan.config.directory = *plan_.arguments.record;
    plan.name = plan_.config.name;
    plan.description.program_version = kVersion;
    plan.description.config_text = plan_.config.text;
    plan.description.site_text = plan_.config.site_text;
    plan.description.utc_minus_host_time = utc_minus_host_time_;
    plan.description.other["name"] = plan_.config.name;
    plan.is_replay = is_replay_;
    plan.has_pictures = !plan_.cameras.empty();
    plan.at_start = plan_.config.recording.at_start || plan_.arguments.record || plan_.record_file;
    plan.file = plan_.record_file;
    plan.image_storage = plan_.image_storage;
    return plan;
  }

  RecordingCallbacks recording_callbacks() {
    RecordingCallbacks callbacks;
    callbacks.upstream_counters = [this] { return health_.upstream_counters(); };
    callbacks.mark = [this](OperatorAction mark) { pipeline_.act(std::move(mark), host_now()); };
    callbacks.lost = [this](StreamId stream) {
      pipeline_.counters().of(stream).dropped.fetch_add(1, std::memory_order_relaxed);
    };
    return callbacks;
  }

  Pipeline::Options pipeline_options() {
    Pipeline::Options options;
    options.sequencer.window = plan_.config.window;
    options.skip_after_frames = is_replay_ ? 0 : plan_.config.skip_after_frames;
    options.recorded_skips = plan_.recorded_skips;
    return options;
  }

  Pipeline::Stages make_stages() {
    return {.trackers = make_trackers(plan_, streams_),
            .estimation = std::make_unique<estimation::EstimationStage>(streams_, plan_.config.estimation)};
  }

  Pipeline::Hooks hooks() {
    Pipeline::Hooks hooks;
    hooks.input = [this](const Sample& sample, HostTime log_time) {
      if (first_input_.load() == kNoInput) first_input_ = to_ns(log_time);
      recording_.input(sample, log_time);
      // Everything else is shown further on, where it has its place in the order.
      if (display_ && sample.kind() == SampleKind::raw_bytes) display_->publish(sample, log_time);
    };
    hooks.frame = [this](const Sample& sample, HostTime log_time) {
      if (display_ && is_shown(sample)) display_->publish(sample, log_time);
    };
    hooks.analysed = [this](const Sample& sample, HostTime log_time) {
      const bool is_derived = streams_.info(sample.header.stream).role == StreamRole::derived;
      if (is_derived) {
        pipeline_.counters().of(sample.header.stream).received.fetch_add(1, std::memory_order_relaxed);
        digest_->add(sample, streams_);
      }
      recording_.analysed(sample, log_time);
      results_->see(sample);
      if (display_) display_->publish(sample, log_time);
    };
    hooks.restarted = [this](bool /*whole*/) { start_over(); };
    return hooks;
  }

  /// The replay has jumped: what comes next is analysed, digested and judged as if it were all.
  void start_over() {
    played_before_s_ = session_seconds();
    // What leads up to the place does not count as played.
    const PlayerState player = plan_.player->state();
    first_input_ = player.position > player.begin ? to_ns(player.position) : kNoInput;
    digest_ = std::make_unique<Digest>();
    results_ = std::make_unique<ResultCollector>(streams_);
    if (display_) display_->restart();
    if (!recording_.is_recording()) return;
    log("recorder")->warn("the replay went to another place: its recording ends here, for a session's time never goes back");
    recording_.end_here();
  }

  /// A paused replay shows its position: the analysis has to see a little more than that.
  bool is_shown(const Sample& frame) const {
    if (!is_replay_) return true;
    const PlayerState player = plan_.player->state();
    return player.playing || frame.header.sample_time <= player.position;
  }

  Result<void> start_display() {
    if (plan_.arguments.headless) return {};
    display::DisplayOptions options;
    options.address = plan_.config.display.address;
    options.port = plan_.arguments.port.value_or(plan_.config.display.port);
    options.session_name = plan_.config.name;
    options.mode = plan_.mode;
    options.version = kVersion;
    options.civil_from_host = utc_minus_host_time_;
    options.marks = plan_.marks;
    display::DisplayCallbacks callbacks;
    callbacks.on_action = [this](const OperatorAction& action) { return act(action); };
    auto server = std::make_unique<display::DisplayServer>(options, streams_, std::move(callbacks), plan_.player);
    const auto port = server->start();
    if (!port) return port.error();
    display_ = std::move(server);
    std::fputs(fmt::format("live page: http://{}:{}\n", options.address, *port).c_str(), stderr);
    return {};
  }

  /// In the display's thread: an answer the operator sees at once, the deed as an input.
  Result<void> act(const OperatorAction& action) {
    if (auto allowed = recording_.allows(action); !allowed) return allowed;
    pipeline_.act(action, host_now());
    return {};
  }

  void run_threads(const StopSignals& signals, HostTime begin) {
    std::atomic<bool> done{false};
    std::jthread sequencer([this, &done](const std::stop_token& stop) {
      pipeline_.run(stop);
      done = true;
    });
    notify_ready();
    Progress progress(plan_.mode);
    HostTime next_health = begin;
    while (!done) {
      const auto caught = signals.wait_for_any(kControlInterval);
      const HostTime now = host_now();
      const bool time_is_up = plan_.arguments.seconds && to_seconds(now - begin) >= *plan_.arguments.seconds;
      if (caught == StopSignals::Caught::stop || time_is_up) sequencer.request_stop();
      if (plan_.stay_at_end) plan_.stay_at_end(is_watched(now));
      if (caught == StopSignals::Caught::trigger) {
        pipeline_.act({.kind = OperatorAction::Kind::trigger, .text = "signal"}, now);
      }
      recording_.look_after(now);
      if (now >= next_health) {
        next_health = now + kHealthInterval;
        publish_health(now);
      }
      if (plan_.expected_duration_s > 0) progress.update(session_seconds() / plan_.expected_duration_s);
    }
  }

  bool is_watched(HostTime now) {
    if (display_ && display_->viewers() > 0) last_watched_ = now;
    return last_watched_ && now - *last_watched_ < kViewerGrace;
  }

  void publish_health(HostTime now) {
    // On the axis of the samples: in a replay that is the recording's time.
    const HostTime session_now = is_replay_ ? pipeline_.position() : now;
    for (const Sample& drop : health_.new_drops(session_now)) {
      recording_.about_itself(drop, session_now);
      if (display_) display_->publish(drop, session_now);
    }
    Sample sample = health_.sample(session_now);
    recording_.report(std::get<Health>(sample.payload));
    recording_.about_itself(sample, session_now);
    if (display_) display_->publish(sample, session_now);
    const auto& health = std::get<Health>(sample.payload);
    notify_alive(health.recording_path.empty() ? "not recording" : "recording to " + health.recording_path);
  }

  double session_seconds() const {
    const std::int64_t first_ns = first_input_.load();
    const double since_s = first_ns == kNoInput ? 0 : to_seconds(pipeline_.position() - host_time_from_ns(first_ns));
    return played_before_s_ + std::max(since_s, 0.0);
  }

  void report(double wall_s) {
    RunFacts facts;
    facts.duration_s = session_seconds();
    facts.wall_s = wall_s;
    facts.recording = recording_.recorder().state().path;
    facts.digest = digest_->hex();
    facts.streams = health_.counters();
    facts.clocks = pipeline_.clocks();
    facts.cpu_s = pipeline_.cpu_seconds();
    if (display_) facts.display_dropped = display_->dropped();
    const std::string text = plan_.arguments.json ? summary_json(facts, *results_) + "\n" : summary_text(facts, *results_);
    std::fputs(text.c_str(), stdout);
    std::fflush(stdout);
  }

  static constexpr std::int64_t kNoInput = std::numeric_limits<std::int64_t>::min();

  SessionPlan plan_;
  const bool is_replay_;
  const Duration utc_minus_host_time_;
  StreamTable streams_;
  std::unique_ptr<ResultCollector> results_;  // of what came since the replay's last jump
  std::unique_ptr<Digest> digest_;            // likewise
  std::unique_ptr<display::DisplayServer> display_;
  Recording recording_;
  Pipeline pipeline_;
  HealthReporter health_;
  std::atomic<std::int64_t> first_input_{kNoInput};
  std::atomic<double> played_before_s_{0};  // before the replay's last jump
  std::optional<HostTime> last_watched_;
};

}  // namespace

int run_session(SessionPlan plan) {
  // Each camera has a thread of its own: OpenCV's workers would only compete with them.
  cv::setNumThreads(1);
  return Session(std::move(plan)).run();
}

}  // namespace roseau::daemon
