#include "daemon/supervisor.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "core/log.h"

namespace roseau::daemon {

namespace {

constexpr std::chrono::milliseconds kReadTimeout{100};

/// Trying again cannot help: the configuration is wrong, or a recording is not there or broken.
bool is_permanent(const Error& error, bool live) {
  return !live || error.code == ErrorCode::invalid_argument || error.code == ErrorCode::unsupported;
}

}  // namespace

class Supervisor::Runner {
 public:
  Runner(const Options& options, StreamTable& streams, std::unique_ptr<SampleSource> source, sync::Inlet& inlet)
      : options_(options), streams_(streams), source_(std::move(source)), inlet_(inlet), name_(source_->name()) {}

  void start() {
    thread_ = std::jthread([this](const std::stop_token& stop) {
      // Nothing below throws; a library that does so against its word must not take the other devices down.
      try {
        live(stop);
      } catch (const std::exception& error) {
        set(DeviceState::failed, std::string("stopped by an unexpected error: ") + error.what());
      }
      source_->close();
      inlet_.finish();
    });
  }
  void request_stop() { thread_.request_stop(); }
  void join() {
    if (thread_.joinable()) thread_.join();
  }

  Health::Device status() const {
    const std::scoped_lock lock(mutex_);
    return {name_, state_, message_};
  }

 private:
  void set(DeviceState state, std::string message) {
    const std::scoped_lock lock(mutex_);
    if (state == state_ && message == message_) return;
    if (!message.empty()) log(name_)->log(state == DeviceState::failed ? spdlog::level::err : spdlog::level::warn, message);
    if (message.empty() && state == DeviceState::running && state_ != DeviceState::starting) log(name_)->info("running again");
    state_ = state;
    message_ = std::move(message);
  }

  void live(const std::stop_token& stop) {
    auto backoff = options_.first_backoff;
    while (!stop.stop_requested()) {
      Result<void> outcome = source_->open(streams_);
      if (outcome) {
        set(DeviceState::running, "");
        const auto finished = read_until_lost(stop, backoff);
        if (finished && *finished) {
          set(DeviceState::finished, "");
          return;
        }
        if (!finished) outcome = finished.error();
        source_->close();
      }
      if (stop.stop_requested()) return;
      if (!outcome && is_permanent(outcome.error(), source_->is_live())) {
        set(DeviceState::failed, outcome.error().message);
        return;
      }
      set(DeviceState::reopening, outcome ? "closed; opening it again" : outcome.error().message + " (trying again)");
      wait(stop, backoff);
      backoff = std::min(backoff * 2, options_.longest_backoff);
    }
  }

  /// True: the source has ended. False: asked to stop. Error: lost.
  Result<bool> read_until_lost(const std::stop_token& stop, std::chrono::milliseconds& backoff) {
    auto last_data = std::chrono::steady_clock::now();
    while (!stop.stop_requested()) {
      const auto status = source_->read(inlet_, kReadTimeout);
      if (!status) return status.error();
      if (*status == ReadStatus::finished) return true;
      if (*status == ReadStatus::jumped) inlet_.restart(/*discard=*/true);
      if (*status == ReadStatus::round_ended) inlet_.restart(/*discard=*/false);
      const auto now = std::chrono::steady_clock::now();
      if (*status == ReadStatus::more) {
        last_data = now;
        backoff = options_.first_backoff;
        set(DeviceState::running, "");
      } else if (source_->is_live() && now - last_data > options_.silence) {
        set(DeviceState::degraded, "silent - check its cable and power");
      }
    }
    return false;
  }

  void wait(const std::stop_token& stop, std::chrono::milliseconds duration) {
    std::unique_lock lock(wait_mutex_);
    wait_condition_.wait_for(lock, stop, duration, [] { return false; });
  }

  const Options options_;
  StreamTable& streams_;
  std::unique_ptr<SampleSource> source_;
  sync::Inlet& inlet_;
  const std::string name_;
  mutable std::mutex mutex_;
  DeviceState state_ = DeviceState::starting;
  std::string message_;
  std::mutex wait_mutex_;
  std::condition_variable_any wait_condition_;
  std::jthread thread_;  // last: joined before anything it uses goes
};

Supervisor::Supervisor(Options options, StreamTable& streams, sync::Intake& intake)
    : options_(options), streams_(streams), intake_(intake) {}

Supervisor::~Supervisor() { stop(); }

void Supervisor::add(std::unique_ptr<SampleSource> source, std::size_t ring_capacity) {
  auto& inlet = intake_.add_inlet(source->is_live(), ring_capacity);
  runners_.push_back(std::make_unique<Runner>(options_, streams_, std::move(source), inlet));
}

void Supervisor::start() {
  for (auto& runner : runners_) runner->start();
}

void Supervisor::stop() {
  for (auto& runner : runners_) runner->request_stop();
  for (auto& runner : runners_) runner->join();
}

std::vector<Health::Device> Supervisor::devices() const {
  std::vector<Health::Device> devices;
  for (const auto& runner : runners_) devices.push_back(runner->status());
  return devices;
}

std::string Supervisor::first_failure() const {
  for (const auto& runner : runners_) {
    const auto status = runner->status();
    if (status.state == DeviceState::failed) return status.name + ": " + status.message;
  }
  return {};
}

bool Supervisor::all_finished() const {
  return std::ranges::all_of(runners_, [](const auto& runner) {
    const auto state = runner->status().state;
    return state == DeviceState::finished || state == DeviceState::failed;
  });
}

}  // namespace roseau::daemon
