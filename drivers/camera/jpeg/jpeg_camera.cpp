#include "drivers/camera/jpeg/jpeg_camera.h"

#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "core/log.h"

namespace roseau::camera {

namespace {
constexpr std::chrono::milliseconds kReadTimeout{50};
constexpr std::chrono::milliseconds kBufferWait{1};
constexpr std::size_t kMostOthersWaiting = 1024;  // samples that are no frames
}  // namespace

/// The threads of an open live camera: one reads it, some code, and the owner takes what is done.
class JpegCamera::Workshop {
 public:
  Workshop(SampleSource& camera, const JpegOptions& options, CodedBuffers& buffers)
      : camera_(camera), options_(options), buffers_(buffers) {
    for (std::size_t i = 0; i < options_.threads; ++i) threads_.emplace_back([this] { code_until_stopped(); });
    threads_.emplace_back([this] { read_until_stopped(); });
  }
  ~Workshop() {
    {
      const std::scoped_lock lock(mutex_);
      stopping_ = true;
    }
    work_ready_.notify_all();
    threads_.clear();
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;

  Result<ReadStatus> deliver(SampleSink& sink, std::chrono::milliseconds timeout) {
    std::vector<Sample> done;
    std::map<StreamId, std::uint64_t> dropped;
    std::optional<Result<ReadStatus>> end;
    {
      std::unique_lock lock(mutex_);
      done_ready_.wait_for(lock, timeout, [this] { return front_is_done() || (jobs_.empty() && end_) || !dropped_.empty(); });
      while (front_is_done()) {
        if (!jobs_.front().lost) done.push_back(std::move(jobs_.front().sample));
        jobs_.pop_front();
        ++jobs_begin_;
      }
      dropped = std::exchange(dropped_, {});
      if (jobs_.empty()) end = end_;
    }
    for (const auto& [stream, count] : dropped) sink.drop(stream, count);
    for (Sample& sample : done) sink.receive(std::move(sample));
    if (!done.empty()) return ReadStatus::more;
    return end ? *end : ReadStatus::idle;
  }

 private:
  struct Job {
    Sample sample;
    bool done = false;
    bool lost = false;
  };

  /// What the camera gives goes to the end of the queue.
  class Entrance final : public SampleSink {
   public:
    explicit Entrance(Workshop& workshop) : workshop_(workshop) {}
    bool receive(Sample sample) override { return workshop_.take(std::move(sample)); }
    void drop(StreamId stream, std::uint64_t count) override {
      const std::scoped_lock lock(workshop_.mutex_);
      workshop_.dropped_[stream] += count;
    }

   private:
    Workshop& workshop_;
  };

  bool front_is_done() const { return !jobs_.empty() && jobs_.front().done; }

  bool take(Sample sample) {
    const bool is_frame = sample.kind() == SampleKind::frame;
    const std::scoped_lock lock(mutex_);
    if (is_frame ? frames_waiting_ >= options_.most_waiting : jobs_.size() >= kMostOthersWaiting) {
      ++dropped_[sample.header.stream];
      done_ready_.notify_one();
      return false;
    }
    jobs_.push_back({.sample = std::move(sample), .done = !is_frame});
    if (is_frame) {
      ++frames_waiting_;
      to_code_.push_back(jobs_begin_ + jobs_.size() - 1);
      work_ready_.notify_one();
    } else {
      done_ready_.notify_one();
    }
    return true;
  }

  void read_until_stopped() {
    Entrance entrance(*this);
    while (true) {
      {
        const std::scoped_lock lock(mutex_);
        if (stopping_ || end_) return;
      }
      auto status = camera_.read(entrance, kReadTimeout);
      if (status && *status != ReadStatus::finished) continue;
      const std::scoped_lock lock(mutex_);
      end_ = std::move(status);
      done_ready_.notify_one();
    }
  }

  void code_until_stopped() {
    FrameCoder coder(options_.quality);
    std::unique_lock lock(mutex_);
    while (true) {
      work_ready_.wait(lock, [this] { return stopping_ || !to_code_.empty(); });
      if (stopping_) return;
      // The job stays where it is in memory while others are added behind it and taken before it.
      Job& job = jobs_[to_code_.front() - jobs_begin_];
      to_code_.pop_front();
      lock.unlock();
      const bool is_coded = code(coder, job.sample);
      lock.lock();
      if (!is_coded) ++dropped_[job.sample.header.stream];
      job.lost = !is_coded;
      job.done = true;
      --frames_waiting_;
      done_ready_.notify_one();
    }
  }

  bool code(FrameCoder& coder, Sample& sample) {
    auto& frame = std::get<Frame>(sample.payload);
    auto buffers = FrameCoder::buffers_for(frame, buffers_);
    if (!buffers) return false;  // consumers hold them all
    const auto coded = coder.code(frame, std::move(buffers));
    if (!coded) log(camera_.name())->error("a frame could not be stored: {}", coded.error().message);
    return coded.has_value();
  }

  SampleSource& camera_;
  const JpegOptions options_;
  CodedBuffers& buffers_;

  std::mutex mutex_;
  std::condition_variable work_ready_;
  std::condition_variable done_ready_;
  std::deque<Job> jobs_;             // numbered from jobs_begin_
  std::deque<std::size_t> to_code_;  // numbers of frames that wait for a thread
  std::size_t jobs_begin_ = 0;
  std::size_t frames_waiting_ = 0;
  std::map<StreamId, std::uint64_t> dropped_;  // not reported yet
  std::optional<Result<ReadStatus>> end_;      // how the camera ended
  bool stopping_ = false;
  std::vector<std::jthread> threads_;  // last: joined before anything they use goes
};

JpegCamera::JpegCamera(std::unique_ptr<SampleSource> camera, const JpegOptions& options)
    : camera_(std::move(camera)), options_(options), coder_(options.quality) {}

JpegCamera::~JpegCamera() = default;

Result<void> JpegCamera::open(StreamTable& streams) {
  auto opened = camera_->open(streams);
  if (opened && is_live()) workshop_ = std::make_unique<Workshop>(*camera_, options_, *buffers_);
  return opened;
}

Result<ReadStatus> JpegCamera::read(SampleSink& sink, std::chrono::milliseconds timeout) {
  if (workshop_) return workshop_->deliver(sink, timeout);
  JpegSink coded(sink, coder_, *buffers_);
  return camera_->read(coded, timeout);
}

void JpegCamera::close() {
  workshop_.reset();
  camera_->close();
}

bool JpegSink::receive(Sample sample) {
  auto* frame = std::get_if<Frame>(&sample.payload);
  if (frame == nullptr) return sink_.receive(std::move(sample));
  auto buffers = FrameCoder::buffers_for(*frame, buffers_);
  while (!buffers) {
    std::this_thread::sleep_for(kBufferWait);
    buffers = FrameCoder::buffers_for(*frame, buffers_);
  }
  if (const auto coded = coder_.code(*frame, std::move(buffers)); !coded) {
    log("jpeg")->error("a frame could not be stored: {}", coded.error().message);
    sink_.drop(sample.header.stream, 1);
    return false;
  }
  return sink_.receive(std::move(sample));
}

}  // namespace roseau::camera
