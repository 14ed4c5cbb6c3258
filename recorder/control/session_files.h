// The files of a recording directory: what they are called, which of them roseau made, which of these may be deleted, and what
// a crash left.
//
//   storm-20261122T140501Z.mcap              first part of a session
//   storm-20261122T140501Z.part002.mcap      second
//   storm-20261122T140501Z.recording         exists, locked, while the session is being recorded: who does it, and which part
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"

namespace roseau::recorder {

/// A file name in its parts.
struct PartName {
  std::string session;  // "storm-20261122T140501Z"
  std::uint32_t part = 1;
};
/// Nothing when a recording would not be called that.
std::optional<PartName> part_name_from(const std::filesystem::path& file);

/// The path of a part, whatever part of its session `file` is.
std::filesystem::path path_of_part(const std::filesystem::path& file, std::uint32_t part);

struct SessionFile {
  std::filesystem::path path;
  PartName name;
  std::uint64_t bytes = 0;
  std::filesystem::file_time_type written;
  bool is_finished = false;  // has the end that a closed file has
};

/// Recordings that roseau made in this directory, by name and by what the file says of itself; oldest first (by session, then
/// part: the names begin with the time within one configuration; across configurations by time of writing). Nothing else is
/// listed, nor anything in folders below or behind links. Files that cannot be read are left out.
std::vector<SessionFile> list_session_files(const std::filesystem::path& directory);

/// Says while a session is being recorded that it is, so that the next start knows what a crash left, and so that nobody
/// touches its files. Held by a lock that ends with the process, however it ends.
class RecordingMarker {
 public:
  struct Note {
    std::string session;
    std::string session_id;  // the recorder's
    std::uint32_t part = 1;
    std::string cause;    // who or what began it
    std::string boot_id;  // of the machine: another one means that it was started anew since
    std::int64_t process = 0;
  };

  /// Error `busy` when another process records this session.
  static Result<RecordingMarker> place(const std::filesystem::path& directory, Note note);
  RecordingMarker(RecordingMarker&& other) noexcept;
  RecordingMarker& operator=(RecordingMarker&& other) noexcept;
  ~RecordingMarker();  // the session has ended: removes it

  /// Another part is being written.
  Result<void> update(std::uint32_t part, const std::string& session_id);
  const Note& note() const { return note_; }

 private:
  RecordingMarker(int fd, std::filesystem::path path, Note note) : fd_(fd), path_(std::move(path)), note_(std::move(note)) {}
  Result<void> write();
  int fd_ = -1;
  std::filesystem::path path_;
  Note note_;
};

/// What recordings that were cut short left in a directory.
struct Interrupted {
  std::vector<std::filesystem::path> files;      // without an end, and nobody is writing them
  std::optional<RecordingMarker::Note> session;  // the newest one that was going on
  std::vector<std::filesystem::path> finished;   // whole parts of sessions that a crash ended
  std::vector<std::filesystem::path> empty;      // of sessions that a crash ended: made, and nothing written yet
  std::vector<std::filesystem::path> markers;    // of sessions nobody records any more
};

/// Files without a marker count when nobody has written them for `quiet`: somebody who makes no markers might.
Interrupted find_interrupted(const std::filesystem::path& directory, std::filesystem::file_time_type now,
                             std::chrono::seconds quiet = std::chrono::seconds(60));

/// Of the machine's present run; empty where the system does not say.
std::string current_boot_id();

}  // namespace roseau::recorder
