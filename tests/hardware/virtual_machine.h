// A virtual machine (machine.sh) that runs one script, and may be stopped dead at any moment.
#pragma once

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/process.h"

namespace roseau::testing {

class VirtualMachine {
 public:
  /// Boots. `work` is the guest's /mnt; `script` a file in it; the build tree is the guest's /media.
  VirtualMachine(const std::filesystem::path& work, const std::string& script, const std::vector<std::string>& qemu_arguments);

  /// What the guest has said so far: its console.
  std::string console() const { return process_.err(); }
  bool wait_for(const std::string& text, std::chrono::seconds limit) { return process_.wait_for_err(text, limit); }

  /// Pulls the plug.
  void stop_dead();
  /// The script's exit status once the machine has switched itself off; nothing when it has not by then.
  std::optional<int> wait_for_end(std::chrono::seconds limit);

 private:
  std::filesystem::path work_;
  Process process_;
};

/// An empty ext4 file system in a file.
void make_disk(const std::filesystem::path& image, const std::string& size);

/// Repairs the file system as a boot after a power cut would (its journal), then copies everything in it to `folder`. Needs no
/// right to mount. False, and a failed test, when it cannot be repaired.
bool read_disk(const std::filesystem::path& image, const std::filesystem::path& folder);

/// The arguments that give the machine a virtio disk (/dev/vda).
std::vector<std::string> virtio_disk(const std::filesystem::path& image);

/// The newest value of "BEAT <seconds of the guest's monotonic clock>" lines on the console.
double last_beat_s(const std::string& console);

}  // namespace roseau::testing
