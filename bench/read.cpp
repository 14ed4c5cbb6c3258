// What reading costs: seeking in a large session whose pages are not in memory, scanning it with every CRC beside plain read(2)
// of the same file, and recovering one that was cut off. The large file is written by the case and removed at its end;
// ROSEAU_BENCH_GIB says how large (default 10).
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "bench/bench.h"
#include "recorder/format/file_io.h"
#include "recorder/format/indexed_reader.h"
#include "recorder/format/stream_reader.h"
#include "recorder/format/writer.h"
#include "recorder/tools/inspect/verification.h"
#include "recorder/tools/recover/recovery.h"

namespace roseau::bench {

namespace {

constexpr std::size_t kFrameBytes = std::size_t{1280} * 1024;
constexpr std::size_t kFramesPerChunk = 3;
constexpr std::uint64_t kFramePeriod_ns = 1'000'000'000 / 120;  // two cameras at 60 Hz
constexpr std::uint64_t kSmallPerFrame = 8;                     // samples of sonic, tracker and the rest: about 1 kHz
constexpr int kSeeks = 15;
constexpr std::uint64_t kMostRecoverBytes = std::uint64_t{2} << 30U;
constexpr std::size_t kReadBytes = 4U << 20U;

double wall_seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

double cpu_seconds() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

struct Rate {
  double wall_megabytes_per_s = 0;
  double cpu_megabytes_per_s = 0;
};

std::uint64_t wanted_bytes() {
  const char* const gib = std::getenv("ROSEAU_BENCH_GIB");
  const double wanted = gib == nullptr ? 10 : std::strtod(gib, nullptr);
  return static_cast<std::uint64_t>(std::max(0.05, wanted) * 1073741824.0);
}

/// Removes the file with the object.
class Scratch {
 public:
  explicit Scratch(const std::string& name)
      : path_(work_directory() / ("roseau-bench-read-" + std::to_string(::getpid()) + name)) {}
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Every page of the file out of memory.
Result<void> drop_pages(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool done = fd >= 0 && ::fdatasync(fd) == 0 && ::posix_fadvise(fd, 0, 0, POSIX_FADV_DONTNEED) == 0;
  if (fd >= 0) ::close(fd);
  if (!done) return Error{ErrorCode::io, "cannot drop the pages of " + path.string()};
  return {};
}

/// A session as the recorder writes one: pictures in chunks of their own, everything else in compressed ones. `finish` false:
/// cut off.
Result<void> write_session(const std::filesystem::path& path, std::uint64_t bytes, bool finish) {
  auto file = mcap::FileWritable::create(path);
  if (!file) return file.error();
  std::mt19937_64 random(1);
  std::vector<std::byte> noise(16 * kFrameBytes);
  for (std::size_t at = 0; at + 8 <= noise.size(); at += 8) {
    const std::uint64_t word = random();
    std::ranges::copy(std::as_bytes(std::span(&word, 1)), noise.begin() + static_cast<std::ptrdiff_t>(at));
  }
  mcap::Writer writer(**file);
  Result<void> written = writer.begin({"x-roseau", "roseau-bench"});
  for (std::uint16_t id = 1; id <= 3 && written; ++id) {
    written = writer.write(mcap::Channel{id, 0, "/stream" + std::to_string(id), "octets", {}});
  }
  mcap::ChunkBuilder pictures;
  mcap::ChunkBuilder small(mcap::Compression::zstd);
  const std::span<const std::byte> payload(noise);
  for (std::uint32_t i = 0; written && writer.bytes_written() < bytes; ++i) {
    const std::uint64_t time_ns = 1'000'000'000 + i * kFramePeriod_ns;
    const auto camera = static_cast<std::uint16_t>(1 + i % 2);
    pictures.add({camera, i / 2, time_ns, time_ns, {}}, payload.subspan((i % 16) * kFrameBytes, kFrameBytes));
    for (std::uint32_t k = 0; k < kSmallPerFrame; ++k) {
      small.add({3, i * 8 + k, time_ns + 1 + k, time_ns + k, payload.subspan(i % 1000, 40)});
    }
    if ((i + 1) % kFramesPerChunk == 0) {
      written = writer.write(pictures);
      pictures.clear();
    }
    if (written && (i + 1) % 30 == 0) {
      written = writer.write(small);
      small.clear();
    }
  }
  if (written && finish) written = writer.finish();
  (*file)->begin_closing();
  return written ? (*file)->close() : written;
}

/// Work over the whole file, its pages not in memory at first.
template <class Work>
Result<Rate> measure(const std::filesystem::path& path, Work work) {
  if (auto dropped = drop_pages(path); !dropped) return dropped.error();
  const double megabytes = static_cast<double>(std::filesystem::file_size(path)) * 1e-6;
  const double cpu_s = cpu_seconds();
  const double wall_s = wall_seconds();
  if (Result<void> done = work(); !done) return done.error();
  return Rate{megabytes / (wall_seconds() - wall_s), megabytes / (cpu_seconds() - cpu_s)};
}

Result<void> read_plainly(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  static_cast<void>(::posix_fadvise(fd, 0, 0, POSIX_FADV_SEQUENTIAL));
  std::vector<std::byte> buffer(kReadBytes);
  ssize_t got = 0;
  while ((got = ::read(fd, buffer.data(), buffer.size())) > 0) {
  }
  ::close(fd);
  if (got < 0) return Error{ErrorCode::io, "cannot read " + path.string()};
  return {};
}

Result<void> read_streamed(const std::filesystem::path& path) {
  auto file = mcap::FileReadable::open(path);
  if (!file) return file.error();
  mcap::StreamReader reader(**file);
  while (true) {
    const auto record = reader.next();
    if (!record) return record.error();
    if (!*record) return {};
  }
}

Result<void> read_in_order(const std::filesystem::path& path) {
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  auto messages = (*reader)->messages();
  while (true) {
    const auto message = messages.next();
    if (!message) return message.error();
    if (!*message) return {};
  }
}

struct Seek {
  double open_s = 0;   // the file's index
  double first_s = 0;  // from there to the first message
  double total_s() const { return open_s + first_s; }
};

/// Opens the file anew and reads the first message at or after a random time.
Result<Seek> seek(const std::filesystem::path& path, double share, bool small_only) {
  if (auto dropped = drop_pages(path); !dropped) return dropped.error();
  const double begin_s = wall_seconds();
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  const double opened_s = wall_seconds();
  const auto& statistics = (*reader)->index().statistics;
  const auto span = static_cast<double>(statistics.message_end_time_ns - statistics.message_start_time_ns);
  mcap::MessageQuery query{.start_time_ns = statistics.message_start_time_ns + static_cast<std::uint64_t>(share * span)};
  if (small_only) query.channels = {{3}};
  auto messages = (*reader)->messages(query);
  const auto first = messages.next();
  if (!first) return first.error();
  if (!*first) return Error{ErrorCode::corrupt, "no message after the time sought"};
  return Seek{opened_s - begin_s, wall_seconds() - opened_s};
}

Result<std::vector<Seek>> seek_often(const std::filesystem::path& path, bool small_only) {
  std::mt19937 random(2);
  std::vector<Seek> seeks;
  for (int i = 0; i < kSeeks; ++i) {
    const auto one = seek(path, std::uniform_real_distribution(0.05, 0.9)(random), small_only);
    if (!one) return one.error();
    seeks.push_back(*one);
  }
  std::ranges::sort(seeks, {}, &Seek::total_s);
  return seeks;
}

Result<void> add_seeks(const std::filesystem::path& path, nlohmann::ordered_json& figures) {
  for (const bool small_only : {false, true}) {
    const auto seeks = seek_often(path, small_only);
    if (!seeks) return seeks.error();
    const Seek& median = (*seeks)[seeks->size() / 2];
    const std::string name = small_only ? "seek_one_stream" : "seek_all_streams";
    figures[name + "_median_ms"] = median.total_s() * 1e3;
    figures[name + "_max_ms"] = seeks->back().total_s() * 1e3;
    figures[name + "_of_that_open_ms"] = median.open_s * 1e3;
    figures[name + "_of_that_first_message_ms"] = median.first_s * 1e3;
  }
  auto reader = mcap::IndexedReader::open(path);
  if (!reader) return reader.error();
  figures["chunks_count"] = (*reader)->index().statistics.chunk_count;
  figures["messages_count"] = (*reader)->index().statistics.message_count;
  return {};
}

void add_rate(const std::string& name, const Rate& rate, nlohmann::ordered_json& figures) {
  figures[name + "_megabytes_per_s"] = rate.wall_megabytes_per_s;
  figures[name + "_megabytes_per_cpu_s"] = rate.cpu_megabytes_per_s;
}

Result<void> add_scans(const std::filesystem::path& path, nlohmann::ordered_json& figures) {
  const std::pair<const char*, std::function<Result<void>()>> scans[] = {
      {"reference_plain_read", [&] { return read_plainly(path); }},
      {"scan_streamed_with_crcs", [&] { return read_streamed(path); }},
      {"scan_indexed_in_order", [&] { return read_in_order(path); }},
      {"verify",
       [&]() -> Result<void> {
         const auto found = recorder::verify_session(path);
         if (!found) return found.error();
         if (found->problem_count > 0) return Error{ErrorCode::corrupt, found->problems.front()};
         return {};
       }},
  };
  for (const auto& [name, scan] : scans) {
    const auto rate = measure(path, scan);
    if (!rate) return rate.error();
    add_rate(name, *rate, figures);
  }
  return {};
}

Result<void> add_recovery(std::uint64_t bytes, nlohmann::ordered_json& figures) {
  const Scratch cut("-cut.mcap");
  const Scratch whole("-recovered.mcap");
  if (auto written = write_session(cut.path(), std::min(bytes, kMostRecoverBytes), false); !written) return written;
  const auto rate = measure(cut.path(), [&]() -> Result<void> {
    const auto recovery = recorder::recover_session(cut.path(), whole.path());
    if (!recovery) return recovery.error();
    return {};
  });
  if (!rate) return rate.error();
  add_rate("recover", *rate, figures);
  const auto in_place = measure(cut.path(), [&]() -> Result<void> {
    const auto recovery = recorder::recover_in_place(cut.path());
    if (!recovery) return recovery.error();
    return {};
  });
  if (!in_place) return in_place.error();
  add_rate("recover_in_place", *in_place, figures);
  return {};
}

Result<nlohmann::ordered_json> run() {
  const std::uint64_t bytes = wanted_bytes();
  std::error_code unknown;
  const auto space = std::filesystem::space(work_directory(), unknown);
  if (!unknown && space.available < bytes + 3 * kMostRecoverBytes) {
    return Error{ErrorCode::no_space, work_directory().string() +
                                          " has too little space: name another directory with --dir, or "
                                          "less with ROSEAU_BENCH_GIB"};
  }
  nlohmann::ordered_json figures = {{"case", "read"}};
  {
    const Scratch session(".mcap");
    if (auto written = write_session(session.path(), bytes, true); !written) return written.error();
    figures["file_bytes"] = std::filesystem::file_size(session.path());
    if (auto added = add_seeks(session.path(), figures); !added) return added.error();
    if (auto added = add_scans(session.path(), figures); !added) return added.error();
  }
  if (auto added = add_recovery(bytes, figures); !added) return added.error();
  return figures;
}

}  // namespace

void add_reading_cases(std::vector<Case>& cases) {
  cases.push_back({"read", "seek, scan, verify and recover a 10 GiB session (ROSEAU_BENCH_GIB) in --dir", run});
}

}  // namespace roseau::bench
