// Recovering a session that was cut off or damaged: everything that can be read goes into a whole MCAP file, and what is lost
// is said exactly.
//
// Kept: every message of every chunk whose CRC matches, and the chunk itself as it was stored (nothing is compressed anew);
// attachments whose CRC matches, metadata, the recorder's checkpoints, private records; schemas and channels wherever they are
// defined (an intact summary counts). Damage costs only itself: behind it the search goes on for the next record that proves
// itself. The last chunk of a cut file, when it is not compressed, gives the messages whose bytes are all there: they are
// marked as unchecked, since the chunk's CRC covers bytes that are missing.
//
// Pure functions of the file; no threads. Memory: a few times the largest record, plus 20 bytes per message of one chunk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/sample.h"
#include "recorder/format/chunk_records.h"
#include "recorder/format/io.h"

namespace roseau::recorder {

/// A stretch of the file whose content is lost, or was saved only in part.
struct LostStretch {
  std::uint64_t offset = 0;
  std::uint64_t bytes = 0;
  std::string reason;
  /// Log times between which messages are missing: of the chunk's own head where that reads, else of the messages kept on both
  /// sides. Nothing where there is no side: a stretch at the end is open.
  std::optional<std::uint64_t> from_ns;
  std::optional<std::uint64_t> to_ns;
  /// Messages that stood in it, by topic, as the message indexes behind it say.
  std::map<std::string, std::uint64_t> messages;
  /// By how many the topic's sequence numbers jump across it. A device's own gaps count too.
  std::map<std::string, std::uint64_t> sequence_jump;
  std::uint64_t saved_messages = 0;  // taken out of it, unchecked
};

struct TopicRecovery {
  std::string topic;
  std::uint64_t messages = 0;  // kept
  std::uint64_t first_ns = 0;  // log times of those
  std::uint64_t last_ns = 0;
  /// Surely lost: by the file's statistics or its recorder's counters against what was found, else by message indexes.
  std::uint64_t lost = 0;
  /// How many numbers are missing in the sequence, all in all.
  std::uint64_t missing_in_sequence = 0;
  /// As the recorder counted them last (at the end, or at the last checkpoint of a cut file).
  std::optional<StreamCounters> counters;
};

struct Recovery {
  std::filesystem::path input;
  std::filesystem::path output;
  bool was_whole = false;  // nothing was wrong: the output has the same content
  bool in_place = false;
  std::uint64_t input_bytes = 0;
  std::uint64_t output_bytes = 0;
  std::uint64_t messages = 0;
  std::uint64_t unchecked_messages = 0;  // of these: saved from a torn chunk, whose CRC could not be checked
  std::uint64_t chunks = 0;
  std::uint64_t attachments = 0;
  std::uint64_t metadata = 0;
  std::uint64_t checkpoints = 0;
  std::uint64_t lost_bytes = 0;
  std::vector<LostStretch> lost;
  std::vector<TopicRecovery> topics;  // by topic
  std::vector<std::string> remarks;   // what else was found and mended, one sentence each
  /// Log time of the last message kept and of the last checkpoint: behind the later of them nothing is known of a cut file.
  std::optional<std::uint64_t> last_message_ns;
  std::optional<std::filesystem::path> torn_bytes;  // in place: where the bytes went that were cut off
};

struct RecoverOptions {
  std::function<bool(double share)> progress;  // called now and then; false: stop, and leave nothing behind
  mcap::ReaderOptions reader;
};

/// Rebuilds `input` into the new file `output`; the input is only read. Errors: the output exists already, the disk is full
/// (the unfinished output is removed), nothing in the input can be read, stopped by progress.
Result<Recovery> recover_session(const std::filesystem::path& input, const std::filesystem::path& output,
                                 const RecoverOptions& options = {});

/// The same from and to anything; `out` must be new.
Result<Recovery> recover_session(mcap::Readable& in, mcap::Writable& out, const RecoverOptions& options = {});

/// Gives the file itself its missing end. Only for a file that was cut off: its bytes up to the last good record stay as they
/// are (they are compared), the torn rest is first copied to FILE.torn, and then the summary takes its place. A power cut at
/// any moment leaves a file that can be recovered again. Errors: unsupported when there is damage further in front (recover
/// into a new file then), busy when a recorder has the file open, no_space before anything is changed.
Result<Recovery> recover_in_place(const std::filesystem::path& path, const RecoverOptions& options = {});

/// Whether the file ends as it should: quick (reads the footer and the summary), for finding sessions that a crash left.
Result<bool> ends_properly(const std::filesystem::path& path);

std::string to_text(const Recovery& recovery);
std::string to_json(const Recovery& recovery);

}  // namespace roseau::recorder
