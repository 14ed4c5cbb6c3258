// Running the real program from a test.
#pragma once

#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

namespace roseau::testing {

/// A child process with its output collected in files. Killed and reaped by the destructor if it still runs.
class Process {
 public:
  Process(std::vector<std::string> command, const std::filesystem::path& directory);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  int pid() const { return pid_; }
  void signal(int number) const;
  /// Exit status, or -signal when a signal ended it; -1000 after the time limit (the process is then killed).
  int wait(std::chrono::seconds limit = std::chrono::seconds(100));
  bool running();

  std::string out() const;  // what it has written so far
  std::string err() const;

  /// Waits until its standard error holds `text`; false after the time limit or its end.
  bool wait_for_err(const std::string& text, std::chrono::seconds limit = std::chrono::seconds(30));

 private:
  int pid_ = -1;
  int status_ = 0;
  bool ended_ = false;
  std::filesystem::path out_path_;
  std::filesystem::path err_path_;
};

}  // namespace roseau::testing
