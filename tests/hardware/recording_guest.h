// A guest that records: a camera (a video played as one) and a sonic anemometer (lines over TCP on loopback), by the real
// program, onto a disk of its own.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/support/raw_avi.h"
#include "tests/support/temporary_folder.h"

namespace roseau::testing {

/// 160 x 120 at 10 Hz for two minutes: noise, so that nothing can be compressed away.
inline std::string noise_video() {
  RawAvi video{.width = 160, .height = 120, .rate_hz = 10, .announced_frames = 1200, .chunks = {}};
  std::uint64_t state = 1;
  for (std::uint32_t i = 0; i < video.announced_frames; ++i) {
    std::string picture(std::size_t{video.width} * video.height * 3, '\0');
    for (char& byte : picture) {
      state = state * 6364136223846793005ULL + 1442695040888963407ULL;
      byte = static_cast<char>(state >> 56U);
    }
    video.chunks.push_back(std::move(picture));
  }
  return video.bytes();
}

/// Writes the guest's files into `work`: `prepare` mounts the disk on /tmp/disk; `meanwhile` runs beside the recording, which
/// takes `seconds`. The script's status is the program's.
inline void write_recording_guest(const TemporaryFolder& work, const std::string& prepare, const std::string& meanwhile,
                                  int seconds) {
  work.write("video.avi", noise_video());
  work.write("live.toml", R"([[camera]]
name = "camera0"
driver = "video_file"
path = "video.avi"
grey = true
[[sonic]]
name = "sonic"
model = "gill_windsonic"
port = "tcp-listen://127.0.0.1:4001"
[tracking]
feature_count = 20
[recording]
least_free_mib = 0
)");
  work.write("record.sh", fmt::format(R"sh(mkdir -p /tmp/disk
{}
/media/bin/roseau run /mnt/live.toml --headless --json --record /tmp/disk --for {} > /mnt/summary.json &
recorder=$!
(while :; do
  exec 3<>/dev/tcp/127.0.0.1/4001 && while printf '\x02Q,229,002.74,M,00,\x0316\r\n' >&3; do sleep 0.1; done
  sleep 0.5
done) 2>/dev/null &
while :; do echo "BEAT $(cut -d' ' -f1 /proc/uptime)"; sleep 0.2; done &
{}
wait $recorder
)sh",
                                      prepare, seconds, meanwhile));
}

/// The one session file below `folder`.
inline std::filesystem::path only_session(const std::filesystem::path& folder) {
  std::filesystem::path found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".mcap") found = entry.path();
  }
  EXPECT_FALSE(found.empty()) << "no session in " << folder;
  return found;
}

}  // namespace roseau::testing
