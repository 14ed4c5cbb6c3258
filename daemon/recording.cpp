#include "daemon/recording.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/log.h"
#include "recorder/tools/recover/recovery.h"

namespace roseau::daemon {

namespace {

using std::filesystem::path;

constexpr Duration kLookInterval = std::chrono::seconds(1);
constexpr Duration kListingInterval = std::chrono::seconds(5);
// Of the second copy, when a session ends.
constexpr std::chrono::seconds kCopyGrace{20};
constexpr std::string_view kOperator = "operator";
constexpr std::string_view kAtStart = "at start";
constexpr std::string_view kTriggerPrefix = "trigger";

std::uint64_t bytes_from_mib(double mib) { return static_cast<std::uint64_t>(mib * 1024 * 1024); }

std::optional<std::uint64_t> free_bytes_of(const path& directory) {
  std::error_code error;
  const auto space = std::filesystem::space(directory, error);
  return error ? std::nullopt : std::optional(space.available);
}

recorder::DiskGuardOptions guard_options(const RecordingConfig& config) {
  return {.least_free_bytes = bytes_from_mib(config.least_free_mib),
          .when_full = config.when_full,
          .keep_at_most_bytes = bytes_from_mib(config.keep_at_most_gib * 1024)};
}

}  // namespace

Recording::Recording(StreamTable& streams, RecordingPlan plan, RecordingCallbacks callbacks)
    : streams_(streams),
      plan_(std::move(plan)),
      callbacks_(std::move(callbacks)),
      recorder_(streams, recorder_options()),
      control_(recorder_, control_options(), control_callbacks()),
      triggers_(plan_.is_replay ? std::vector<recorder::TriggerOptions>{} : plan_.config.triggers, streams),
      disk_guard_(guard_options(plan_.config)),
      battery_guard_(plan_.config.battery_stop_percent) {
  if (!callbacks_.free_bytes) callbacks_.free_bytes = free_bytes_of;
  if (!callbacks_.power) callbacks_.power = [] { return recorder::read_power(); };
  if (!callbacks_.civil_now) callbacks_.civil_now = [] { return std::chrono::system_clock::now(); };
}

Recording::~Recording() { static_cast<void>(finish().has_value()); }

recorder::RecorderOptions Recording::recorder_options() {
  recorder::RecorderOptions options;
  options.queue_bytes = bytes_from_mib(plan_.config.memory_mib);
  options.wait_when_full = plan_.is_replay;
  options.image_storage = plan_.image_storage;
  options.upstream_counters = callbacks_.upstream_counters;
  options.split = {.bytes = bytes_from_mib(plan_.config.split_mib), .time = from_seconds(plan_.config.split_s)};
  options.part_path = recorder::path_of_part;
  options.part_finished = [this](const recorder::FinishedPart& part) { part_finished(part); };
  return options;
}

recorder::ControlOptions Recording::control_options() const {
  recorder::ControlOptions options;
  options.policy.post_trigger = from_seconds(plan_.config.post_trigger_s);
  options.waiting_bytes = bytes_from_mib(plan_.config.memory_mib) / 2;
  if (plan_.is_replay) return options;
  options.policy.pre_trigger = from_seconds(plan_.config.pre_trigger_s);
  options.past.bytes = bytes_from_mib(plan_.config.pre_trigger_mib);
  options.past.has_pictures = plan_.has_pictures;
  return options;
}

recorder::ControlCallbacks Recording::control_callbacks() {
  recorder::ControlCallbacks callbacks;
  callbacks.open = [this](const std::string& cause) { return open(cause); };
  callbacks.closed = [this](const Result<void>& /*logged where it happened*/) {
    const std::scoped_lock lock(files_mutex_);
    marker_.reset();
  };
  callbacks.lost = callbacks_.lost;
  return callbacks;
}

// ---------------------------------------------------------------------------------------------------------------------
// Files

Result<void> Recording::begin() {
  const bool is_unattended = !plan_.is_replay && !plan_.file;
  if (is_unattended && !plan_.config.copy_directory.empty()) {
    const path& second = plan_.config.copy_directory;
    copy_ = std::make_unique<recorder::SecondCopy>(recorder::make_copy_directory(second), second.string(), directory());
  }
  if (is_unattended) {
    auto left = recorder::find_interrupted(directory(), std::filesystem::file_time_type::clock::now());
    if (plan_.config.resume_after_crash && left.session && !left.session->cause.starts_with(kTriggerPrefix)) {
      resumed_ = left.session;
    }
    if (!left.files.empty() || !left.markers.empty()) recover(std::move(left));
  }
  if (!plan_.at_start && !resumed_) return {};
  // A replay begins wherever its recording did.
  const std::string cause = resumed_ ? "after a crash" : std::string(kAtStart);
  if (auto started = control_.start(HostTime::min(), cause); !started) return started;
  return control_.settle();
}

Result<void> Recording::open(const std::string& cause) {
  if (plan_.file) return recorder_.open(*plan_.file, plan_.description);
  std::error_code error;
  std::filesystem::create_directories(directory(), error);
  if (error) {
    return Error{ErrorCode::io, fmt::format("recording directory {}: {}; make it or name another one with --record",
                                            directory().string(), error.message())};
  }
  std::optional<recorder::RecordingMarker::Note> note;
  {
    const std::scoped_lock lock(files_mutex_);
    note = std::exchange(resumed_, std::nullopt);
  }
  return note ? open_resumed(cause, *note) : open_next(cause);
}

Result<void> Recording::open_next(const std::string& cause) {
  auto second = std::chrono::floor<std::chrono::seconds>(callbacks_.civil_now());
  std::string session;
  // Two recordings may begin within one second; nothing is ever written over.
  std::error_code error;
  do {
    session = fmt::format("{}-{:%Y%m%dT%H%M%S}Z", plan_.name, second);
    second += std::chrono::seconds(1);
  } while (std::filesystem::exists(directory() / (session + ".mcap"), error));
  return open_marked(directory() / (session + ".mcap"), {.session = session, .cause = cause}, plan_.description);
}

Result<void> Recording::open_resumed(const std::string& cause, const recorder::RecordingMarker::Note& note) {
  recorder::SessionDescription description = plan_.description;
  description.session_id = note.session_id;
  description.first_part = note.part + 1;
  const path file = recorder::path_of_part(directory() / (note.session + ".mcap"), description.first_part);
  log("recorder")->info("going on with session {}, which was interrupted", note.session);
  return open_marked(file,
                     {.session = note.session, .session_id = note.session_id, .part = description.first_part, .cause = cause},
                     description);
}

Result<void> Recording::open_marked(const path& file, recorder::RecordingMarker::Note note,
                                    recorder::SessionDescription description) {
  const std::scoped_lock lock(files_mutex_);
  auto marker = recorder::RecordingMarker::place(directory(), std::move(note));
  if (!marker) return marker.error();
  if (auto opened = recorder_.open(file, description); !opened) return opened;
  const auto state = recorder_.state();
  marker_ = std::move(*marker);
  if (auto updated = marker_->update(state.part, state.session_id); !updated)
    log("recorder")->warn("{}", updated.error().message);
  log("recorder")->info("recording to {}", file.string());
  return {};
}

void Recording::part_finished(const recorder::FinishedPart& part) {
  if (copy_) copy_->add_finished(part.path);
  if (part.last) return;
  log("recorder")->info("{} is complete: {}", part.path.string(), recorder::words_for_bytes(part.bytes));
  const std::scoped_lock lock(files_mutex_);
  if (!marker_ || marker_->note().part > part.part) return;
  if (auto updated = marker_->update(part.part + 1, part.session_id); !updated)
    log("recorder")->warn("{}", updated.error().message);
}

void Recording::recover(recorder::Interrupted left) {
  const std::string resumed = resumed_ ? resumed_->session : "";
  // Beside the session that begins now: nobody waits for old files.
  recovery_ = std::jthread([this, left = std::move(left), resumed](const std::stop_token& stop) {
    for (const path& file : left.finished) {
      if (copy_) copy_->add_unless_there(file);  // nobody may have come to it
    }
    for (const path& file : left.empty) {
      std::error_code ignored;
      if (std::filesystem::remove(file, ignored))
        log("recorder")->info("removed {}: it was made, and nothing was written", file.string());
    }
    for (const path& file : left.files) {
      if (stop.stop_requested()) return;
      recover_file(file, stop);
    }
    for (const path& marker : left.markers) {
      std::error_code ignored;
      if (marker.stem() != resumed) std::filesystem::remove(marker, ignored);
    }
  });
}

/// The file itself gets its end where only that is missing; else a new one takes its place, and the damaged one stays beside
/// it.
void Recording::recover_file(const path& file, const std::stop_token& stop) {
  recorder::RecoverOptions options;
  options.progress = [&stop](double) { return !stop.stop_requested(); };
  auto recovered = recorder::recover_in_place(file, options);
  if (!recovered && recovered.error().code == ErrorCode::unsupported) {
    const path fresh = file.string() + ".recovering";
    std::error_code error;
    std::filesystem::remove(fresh, error);
    recovered = recorder::recover_session(file, fresh, options);
    if (recovered) std::filesystem::rename(file, file.string() + ".damaged", error);
    if (recovered && !error) std::filesystem::rename(fresh, file, error);
    if (error) log("recorder")->error("{}: {}", fresh.string(), error.message());
  }
  if (!recovered) {
    log("recorder")->error("{} was cut off and cannot be recovered: {}", file.string(), recovered.error().message);
    return;
  }
  log("recorder")
      ->info("{} was cut off and is whole again: {} messages kept, {} bytes could not be read", file.string(),
             recovered->messages, recovered->lost_bytes);
  if (copy_) copy_->add_finished(file);
}

void Recording::end_here() {
  control_.end_here();
  static_cast<void>(control_.settle().has_value());
}

void Recording::settle() {
  static_cast<void>(control_.settle().has_value());
  if (recovery_.joinable()) recovery_.join();
}

Result<void> Recording::finish() {
  auto finished = control_.finish();
  if (recovery_.joinable()) {
    recovery_.request_stop();
    recovery_.join();
  }
  if (copy_ && !copy_->finish(kCopyGrace)) {
    log("copy")->warn("the copy to {} is not complete: the next start goes on with it", plan_.config.copy_directory.string());
  }
  copy_.reset();
  return finished;
}

// ---------------------------------------------------------------------------------------------------------------------
// Samples

void Recording::input(const Sample& sample, HostTime log_time) {
  const auto* action = std::get_if<OperatorAction>(&sample.payload);
  const bool is_order = action != nullptr && !plan_.is_replay;
  // What begins a recording stands in it, and so does what ends it.
  const bool ends = is_order && action->kind == OperatorAction::Kind::stop_recording;
  if (is_order && !ends) obey(*action, log_time);
  control_.take(sample, log_time);
  if (ends) obey(*action, log_time);
}

void Recording::obey(const OperatorAction& action, HostTime log_time) {
  Result<void> obeyed;
  if (action.kind == OperatorAction::Kind::start_recording) obeyed = control_.start(log_time, std::string(kOperator));
  if (action.kind == OperatorAction::Kind::trigger) {
    obeyed = control_.trigger(log_time, action.text.empty() ? std::string(kOperator) : action.text);
  }
  if (action.kind == OperatorAction::Kind::stop_recording) control_.stop(log_time);
  if (!obeyed) log("recorder")->warn("{}", obeyed.error().message);
}

void Recording::analysed(const Sample& sample, HostTime log_time) {
  if (streams_.info(sample.header.stream).role == StreamRole::derived) control_.take(sample, log_time);
  for (const auto& event : triggers_.see(sample, log_time)) on_trigger(event);
}

void Recording::about_itself(const Sample& sample, HostTime log_time) { control_.take(sample, log_time); }

void Recording::on_trigger(const recorder::TriggerEvent& event) {
  if (!event.begins) {
    log("recorder")->info("trigger {} has ended: {}", event.name, event.reason);
    return control_.end_trigger(event.at, event.name);
  }
  log("recorder")->info("trigger {}: {}", event.name, event.reason);
  if (auto begun = control_.begin_trigger(event.at, event.name); !begun) {
    log("recorder")->warn("trigger {} is not recorded: {}", event.name, begun.error().message);
  }
  callbacks_.mark({.kind = OperatorAction::Kind::mark, .text = fmt::format("trigger {}: {}", event.name, event.reason)});
}

Result<void> Recording::allows(const OperatorAction& action) const {
  using Kind = OperatorAction::Kind;
  if (plan_.is_replay) return Error{ErrorCode::unsupported, "this is a replay: nothing can be recorded or marked"};
  const auto status = control_.status();
  const bool begins = action.kind == Kind::start_recording || action.kind == Kind::trigger;
  if (begins && !status.refusal.empty()) return Error{ErrorCode::busy, status.refusal};
  // An operator may take over what a trigger began.
  if (action.kind == Kind::start_recording && status.phase == RecordingPhase::recording &&
      !status.cause.starts_with(kTriggerPrefix)) {
    return Error{ErrorCode::busy, "already recording"};
  }
  if (action.kind == Kind::stop_recording && status.phase == RecordingPhase::idle) {
    return Error{ErrorCode::invalid_argument, "nothing is being recorded"};
  }
  return {};
}

// ---------------------------------------------------------------------------------------------------------------------
// Looking after it

void Recording::look_after(HostTime now) {
  if (plan_.is_replay) return;
  control_.tick(now);
  if (now < next_look_) return;
  next_look_ = now + kLookInterval;
  if (!first_look_) first_look_ = now;
  const auto state = recorder_.state();
  if (state.recording) {
    rate_.add(now, state.session_bytes);
    if (copy_) copy_->follow(state.path, state.bytes);
  } else {
    rate_.pause();
  }
  watch_disk(now);
  warn_of_silent_triggers(now);
}

void Recording::watch_disk(HostTime now) {
  Found found;
  found.power = callbacks_.power();
  found.battery = battery_guard_.judge(found.power);
  // A directory that is still to be made lies on the disk of the one above it.
  path present = directory().empty() ? path(".") : directory();
  std::error_code error;
  while (!std::filesystem::exists(present, error) && present.has_parent_path() && present.parent_path() != present) {
    present = present.parent_path();
  }
  const bool is_ring = plan_.config.when_full == recorder::WhenFull::oldest;
  if (is_ring && now >= next_listing_) {
    next_listing_ = now + kListingInterval;
    recordings_bytes_ = 0;
    for (const auto& file : recorder::list_session_files(directory())) recordings_bytes_ += file.bytes;
  }
  const bool is_recording = recorder_.state().recording;
  found.bytes_per_s = is_recording ? rate_.bytes_per_s() : 0;
  if (const auto free = callbacks_.free_bytes(present)) {
    const auto verdict = disk_guard_.judge(directory(), *free, recordings_bytes_, found.bytes_per_s);
    found.free_bytes = *free;
    found.left_s = verdict.left_s;
    if (verdict.kind == recorder::DiskVerdict::Kind::warn) found.warnings.push_back(verdict.message);
    if (verdict.kind == recorder::DiskVerdict::Kind::full) found.refusal = verdict.message;
    if (verdict.kind == recorder::DiskVerdict::Kind::make_room) {
      make_room(verdict.missing_bytes, *free);
      const auto after = callbacks_.free_bytes(present).value_or(*free);
      if (after < bytes_from_mib(plan_.config.least_free_mib)) {
        found.refusal = fmt::format(
            "{} has {} left and no old recording that may be deleted: recording has stopped, the file is "
            "whole. Free some space or record to another disk",
            directory().string(), recorder::words_for_bytes(after));
      }
    }
  }
  if (found.battery.kind == recorder::BatteryVerdict::Kind::stop) found.refusal = found.battery.message;
  if (found.battery.kind == recorder::BatteryVerdict::Kind::warn) found.warnings.push_back(found.battery.message);
  refuse(now, found.refusal);
  const std::scoped_lock lock(found_mutex_);
  found_ = std::move(found);
}

void Recording::make_room(std::uint64_t missing_bytes, std::uint64_t free_bytes) {
  const auto files = recorder::list_session_files(directory());
  std::vector<path> spared{recorder_.state().path};
  std::vector<path> uncopied = copy_ ? copy_->unfinished() : std::vector<path>{};
  uncopied.insert(uncopied.end(), spared.begin(), spared.end());
  const std::uint64_t freed = remove_files(recorder::oldest_to_delete(files, missing_bytes, uncopied));
  const std::uint64_t least = bytes_from_mib(plan_.config.least_free_mib);
  if (freed >= missing_bytes || free_bytes + freed >= least || !copy_) return;
  // The recording comes before its copies.
  log("recorder")->warn("parts whose copy is not verified yet must go: the second disk is too slow or gone");
  remove_files(recorder::oldest_to_delete(recorder::list_session_files(directory()), missing_bytes - freed, spared));
}

std::uint64_t Recording::remove_files(const std::vector<recorder::SessionFile>& files) {
  std::uint64_t freed = 0;
  for (const auto& file : files) {
    std::error_code error;
    if (std::filesystem::remove(file.path, error)) {
      freed += file.bytes;
      recordings_bytes_ -= std::min(recordings_bytes_, file.bytes);
      log("recorder")
          ->info("deleted {} ({}) to make room, being the oldest", file.path.string(), recorder::words_for_bytes(file.bytes));
    } else {
      log("recorder")->warn("cannot delete {}: {}", file.path.string(), error.message());
    }
  }
  return freed;
}

void Recording::refuse(HostTime now, const std::string& reason) {
  const auto status = control_.status();
  if (reason == status.refusal) return;
  control_.refuse(reason);
  if (!reason.empty()) {
    if (!status.refusal.empty()) return;  // it has stopped already
    log("recorder")->warn("{}", reason);
    was_held_ = status.phase != RecordingPhase::idle && !status.cause.starts_with(kTriggerPrefix);
    control_.stop(now);
  } else if (std::exchange(was_held_, false)) {
    log("recorder")->info("there is room and power again: recording goes on");
    if (auto started = control_.start(now, std::string(kAtStart)); !started)
      log("recorder")->warn("{}", started.error().message);
  }
}

/// A misspelt topic would otherwise be noticed when the storm is over.
void Recording::warn_of_silent_triggers(HostTime now) {
  constexpr Duration kPatience = std::chrono::seconds(60);
  if (warned_of_triggers_ || now - *first_look_ < kPatience) return;
  warned_of_triggers_ = true;
  for (const auto& trigger : plan_.config.triggers) {
    if (!streams_.find(trigger.topic))
      log("recorder")->warn("trigger {}: nothing comes on {} so far", trigger.name, trigger.topic);
  }
}

void Recording::report(Health& health) const {
  const auto state = recorder_.state();
  const auto status = control_.status();
  health.recording_phase = status.phase;
  health.recording_cause = status.cause;
  health.recording_ends_s = to_seconds(status.ends_in);
  health.recording_part = state.recording ? state.part : 0;
  health.session_bytes = state.session_bytes;
  health.pre_trigger_s = to_seconds(status.past_span);
  health.pre_trigger_bytes = status.past_bytes;
  health.pre_trigger_cut_off = status.past_cut_off;
  if (copy_) health.copy = copy_->state();

  const std::scoped_lock lock(found_mutex_);
  health.write_rate_bytes_per_s = found_.bytes_per_s;
  health.disk_free_s = found_.left_s;
  if (found_.free_bytes > 0) health.disk_free_bytes = found_.free_bytes;
  health.battery_percent = found_.power.battery_percent.value_or(0);
  health.on_battery = found_.power.on_battery;
  std::vector<std::string> messages = found_.warnings;
  if (status.lost > 0) {
    messages.push_back(
        fmt::format("{} samples were dropped while the past before a trigger was written (counted per stream): the "
                    "disk is too slow for it. A smaller pre_trigger_s, or a larger pre_trigger_mib, helps",
                    status.lost));
  }
  if (!status.failure.empty()) messages.insert(messages.begin(), status.failure);
  if (!found_.refusal.empty()) messages.insert(messages.begin(), found_.refusal);
  for (const auto& message : messages) health.recorder_message += (health.recorder_message.empty() ? "" : ". ") + message;
  if (!messages.empty() && health.recorder != DeviceState::failed) health.recorder = DeviceState::degraded;
  if (!health.copy.directory.empty()) health.devices.push_back({"copy", health.copy.state, health.copy.message});
  if (found_.battery.kind != recorder::BatteryVerdict::Kind::well) {
    health.devices.push_back({"battery", DeviceState::degraded, found_.battery.message});
  }
}

}  // namespace roseau::daemon
