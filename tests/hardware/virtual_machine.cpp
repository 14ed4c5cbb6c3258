#include "tests/hardware/virtual_machine.h"

#include <gtest/gtest.h>

#include <fstream>

namespace roseau::testing {

namespace {

std::vector<std::string> boot_command(const std::filesystem::path& work, const std::string& script,
                                      const std::vector<std::string>& qemu_arguments) {
  std::vector<std::string> command{ROSEAU_MACHINE, "run", ROSEAU_MACHINE_CACHE, ROSEAU_BUILD, work.string(), script};
  command.insert(command.end(), qemu_arguments.begin(), qemu_arguments.end());
  return command;
}

int run(const std::vector<std::string>& command, const std::filesystem::path& folder) {
  Process process(command, folder);
  const int status = process.wait();
  if (status != 0) std::fputs(process.err().c_str(), stderr);
  return status;
}

}  // namespace

VirtualMachine::VirtualMachine(const std::filesystem::path& work, const std::string& script,
                               const std::vector<std::string>& qemu_arguments)
    : work_(work), process_(boot_command(work, script, qemu_arguments), work) {}

void VirtualMachine::stop_dead() {
  process_.signal(SIGKILL);
  process_.wait();
}

std::optional<int> VirtualMachine::wait_for_end(std::chrono::seconds limit) {
  if (process_.wait(limit) != 0) return {};
  std::ifstream file(work_ / "status");
  int status = 0;
  if (!(file >> status)) return {};
  return status;
}

void make_disk(const std::filesystem::path& image, const std::string& size) {
  std::filesystem::remove(image);
  ASSERT_EQ(
      run({"mkfs.ext4", "-q", "-F", "-E", "lazy_itable_init=0,lazy_journal_init=0", image.string(), size}, image.parent_path()),
      0);
}

bool read_disk(const std::filesystem::path& image, const std::filesystem::path& folder) {
  constexpr int kRepaired = 1;
  Process check({"e2fsck", "-f", "-y", image.string()}, image.parent_path());
  const int status = check.wait();
  EXPECT_LE(status, kRepaired) << check.out() << check.err();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  const int copied = run({"debugfs", "-R", "rdump / " + folder.string(), image.string()}, image.parent_path());
  EXPECT_EQ(copied, 0);
  return status <= kRepaired && copied == 0;
}

std::vector<std::string> virtio_disk(const std::filesystem::path& image) {
  return {"-drive", "file=" + image.string() + ",format=raw,if=virtio,cache=writeback"};
}

double last_beat_s(const std::string& console) {
  const auto at = console.rfind("BEAT ");
  return at == std::string::npos ? 0 : std::atof(console.c_str() + at + 5);
}

}  // namespace roseau::testing
