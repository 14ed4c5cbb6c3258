#include "recorder/control/session_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <utility>

#include "recorder/format/codec.h"
#include "recorder/format/file_io.h"
#include "recorder/recorder.h"

namespace roseau::recorder {

namespace {

constexpr std::string_view kEnding = ".mcap";
constexpr std::string_view kPart = ".part";
constexpr std::string_view kMarker = ".recording";
constexpr std::string_view kProfile = "x-roseau";
constexpr std::string_view kTimePattern = "-00000000T000000Z";  // 0: any digit

bool ends_with_time(std::string_view session) {
  if (session.size() <= kTimePattern.size()) return false;
  const std::string_view time = session.substr(session.size() - kTimePattern.size());
  return std::ranges::equal(time, kTimePattern,
                            [](char c, char pattern) { return pattern == '0' ? c >= '0' && c <= '9' : c == pattern; });
}

/// Magic, then the header record: opcode, length, profile.
bool begins_as_ours(mcap::Readable& file) {
  constexpr std::size_t kHead = mcap::kMagic.size() + 1 + 8 + 4;
  std::array<std::byte, kHead + kProfile.size()> head{};
  if (file.size() < head.size() || !file.read(0, head)) return false;
  const bool is_mcap = std::ranges::equal(std::span(head).first(mcap::kMagic.size()), mcap::kMagic);
  return is_mcap && std::memcmp(head.data() + kHead, kProfile.data(), kProfile.size()) == 0;
}

bool ends_as_closed(mcap::Readable& file) {
  std::array<std::byte, mcap::kMagic.size()> end{};
  if (file.size() < 2 * end.size() || !file.read(file.size() - end.size(), end)) return false;
  return std::ranges::equal(end, mcap::kMagic);
}

Error failure(const std::string& what, const std::filesystem::path& path, int error_number) {
  return {error_number == ENOSPC ? ErrorCode::no_space : ErrorCode::io,
          what + " " + path.string() + ": " + std::strerror(error_number)};
}

/// "key = value" lines.
std::optional<RecordingMarker::Note> read_note(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) return std::nullopt;
  std::map<std::string, std::string> values;
  for (std::string line; std::getline(file, line);) {
    const std::size_t equals = line.find(" = ");
    if (equals != std::string::npos) values[line.substr(0, equals)] = line.substr(equals + 3);
  }
  RecordingMarker::Note note;
  note.session = path.stem().string();
  note.session_id = values["session_id"];
  note.cause = values["cause"];
  note.boot_id = values["boot_id"];
  const std::string& part = values["part"];
  std::from_chars(part.data(), part.data() + part.size(), note.part);
  const std::string& process = values["process"];
  std::from_chars(process.data(), process.data() + process.size(), note.process);
  return note;
}

/// Whether a living process holds the marker's lock.
bool is_held(const std::filesystem::path& marker) {
  const int fd = ::open(marker.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return true;  // not ours to judge: hands off
  const bool held = ::flock(fd, LOCK_EX | LOCK_NB) != 0;
  ::close(fd);
  return held;
}

}  // namespace

std::optional<PartName> part_name_from(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  if (!name.ends_with(kEnding)) return std::nullopt;
  name.resize(name.size() - kEnding.size());
  PartName found;
  const std::size_t dot = name.rfind(kPart);
  if (dot != std::string::npos) {
    const char* digits = name.data() + dot + kPart.size();
    const char* end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(digits, end, found.part);
    if (error != std::errc{} || stop != end || end - digits < 3 || found.part < 2) return std::nullopt;
    name.resize(dot);
  }
  if (!ends_with_time(name)) return std::nullopt;
  found.session = std::move(name);
  return found;
}

std::filesystem::path path_of_part(const std::filesystem::path& file, std::uint32_t part) {
  const auto name = part_name_from(file);
  const auto first = name ? file.parent_path() / (name->session + std::string(kEnding)) : file;
  return default_part_path(first, part);
}

std::vector<SessionFile> list_session_files(const std::filesystem::path& directory) {
  std::vector<SessionFile> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code unreadable;
    const auto name = part_name_from(entry->path());
    if (!name || entry->symlink_status(unreadable).type() != std::filesystem::file_type::regular) continue;
    auto file = mcap::FileReadable::open(entry->path());
    if (!file || !begins_as_ours(**file)) continue;
    const auto written = entry->last_write_time(unreadable);
    files.push_back({entry->path(), *name, (*file)->size(), written, ends_as_closed(**file)});
  }
  std::ranges::sort(files, [](const SessionFile& left, const SessionFile& right) {
    if (left.name.session == right.name.session) return left.name.part < right.name.part;
    // The time of writing can be wrong (a copied directory); the time in the name was when recording began.
    const auto time_of = [](const SessionFile& file) {
      return std::string_view(file.name.session).substr(file.name.session.size() - kTimePattern.size());
    };
    return std::pair(time_of(left), left.name.session) < std::pair(time_of(right), right.name.session);
  });
  return files;
}

Result<RecordingMarker> RecordingMarker::place(const std::filesystem::path& directory, Note note) {
  const auto path = directory / (note.session + std::string(kMarker));
  const int fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) return failure("cannot create", path, errno);
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    ::close(fd);
    return Error{ErrorCode::busy, path.string() + ": another roseau is recording this session"};
  }
  note.boot_id = current_boot_id();
  note.process = ::getpid();
  RecordingMarker marker(fd, path, std::move(note));
  if (auto written = marker.write(); !written) return written.error();
  return marker;
}

RecordingMarker::RecordingMarker(RecordingMarker&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), path_(std::move(other.path_)), note_(std::move(other.note_)) {}

RecordingMarker& RecordingMarker::operator=(RecordingMarker&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(path_, other.path_);
  std::swap(note_, other.note_);
  return *this;
}

RecordingMarker::~RecordingMarker() {
  if (fd_ < 0) return;
  ::unlink(path_.c_str());  // before the lock goes: whoever sees the file without a lock sees a crash
  ::close(fd_);
}

Result<void> RecordingMarker::update(std::uint32_t part, const std::string& session_id) {
  note_.part = part;
  note_.session_id = session_id;
  return write();
}

Result<void> RecordingMarker::write() {
  std::ostringstream text;
  text << "part = " << note_.part << "\nsession_id = " << note_.session_id << "\ncause = " << note_.cause
       << "\nboot_id = " << note_.boot_id << "\nprocess = " << note_.process << "\n";
  const std::string bytes = text.str();
  const ssize_t written = ::pwrite(fd_, bytes.data(), bytes.size(), 0);
  if (written != static_cast<ssize_t>(bytes.size())) return failure("cannot write", path_, written < 0 ? errno : ENOSPC);
  if (::ftruncate(fd_, static_cast<off_t>(bytes.size())) != 0 || ::fdatasync(fd_) != 0) {
    return failure("cannot write", path_, errno);
  }
  return {};
}

Interrupted find_interrupted(const std::filesystem::path& directory, std::filesystem::file_time_type now,
                             std::chrono::seconds quiet) {
  Interrupted found;
  std::set<std::string> running;
  std::set<std::string> crashed;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    if (entry->path().extension() != kMarker || !ends_with_time(entry->path().stem().string())) continue;
    const std::string session = entry->path().stem().string();
    if (is_held(entry->path())) {
      running.insert(session);
      continue;
    }
    crashed.insert(session);
    found.markers.push_back(entry->path());
    auto note = read_note(entry->path());
    const auto time_of = [](const std::string& name) { return name.substr(name.size() - kTimePattern.size()); };
    if (note && (!found.session || time_of(found.session->session) < time_of(session))) found.session = std::move(note);
  }
  for (std::filesystem::directory_iterator entry(directory, error), end; !error && entry != end; entry.increment(error)) {
    const auto name = part_name_from(entry->path());
    if (!name || !crashed.contains(name->session)) continue;
    // A file without a head counts too: its name is taken.
    if (found.session && found.session->session == name->session)
      found.session->part = std::max(found.session->part, name->part);
    std::error_code unreadable;
    if (entry->symlink_status(unreadable).type() == std::filesystem::file_type::regular && entry->file_size(unreadable) == 0) {
      found.empty.push_back(entry->path());
    }
  }
  for (const SessionFile& file : list_session_files(directory)) {
    const std::string& session = file.name.session;
    if (file.is_finished && crashed.contains(session)) found.finished.push_back(file.path);
    if (file.is_finished || running.contains(session)) continue;
    if (!crashed.contains(session) && file.written + quiet > now) continue;
    found.files.push_back(file.path);
  }
  return found;
}

std::string current_boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(file, id);
  return id;
}

}  // namespace roseau::recorder
