// Session: one run of the whole system, live or replayed: pipeline, recorder, display, digest and the control loop that looks
// after them. `run` and `replay` differ only in the plan they make.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/player_control.h"
#include "core/source.h"
#include "daemon/commands.h"
#include "daemon/config.h"

namespace roseau::daemon {

struct SessionPlan {
  Config config;
  std::string mode;  // "live", "demo", "replay"
  std::vector<std::unique_ptr<SampleSource>> sources;
  std::vector<std::string> cameras;                   // devices to track
  std::map<std::string, ImageStorage> image_storage;  // of recordings, by camera; others as their streams say
  std::vector<OperatorAction> first_actions;          // taken as inputs before anything else: targets a scene knows of
  std::set<std::pair<std::string, std::uint32_t>> recorded_skips;
  PlayerControl* player = nullptr;                   // replay only; outlives the session
  std::function<void(bool stay)> stay_at_end;        // replay only: whether its end is waited at, because somebody watches
  std::vector<RecordedMark> marks;                   // replay only: for whoever watches
  std::optional<Duration> utc_minus_host_time;       // known from a recording; else taken from the system's clock
  double expected_duration_s = 0;                    // for the progress bar; 0: unknown
  std::optional<std::filesystem::path> record_file;  // record into exactly this file
  SessionArguments arguments;
};

/// Runs until every source has ended, a signal (SIGINT, SIGTERM) or the time limit comes. Prints the summary. Returns the
/// process's exit status.
int run_session(SessionPlan plan);

}  // namespace roseau::daemon
