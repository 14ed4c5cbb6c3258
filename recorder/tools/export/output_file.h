// OutputFile: a new file written through a buffer, every write checked, removed again unless it was kept.
#pragma once

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/result.h"

namespace roseau::recorder {

/// Removes the file at its end unless kept.
class RemoveUnlessKept {
 public:
  explicit RemoveUnlessKept(std::filesystem::path path) : path_(std::move(path)) {}
  RemoveUnlessKept(RemoveUnlessKept&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  RemoveUnlessKept& operator=(RemoveUnlessKept&&) = delete;
  ~RemoveUnlessKept() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove(path_, ignored);
  }
  void keep() { path_.clear(); }

 private:
  std::filesystem::path path_;
};

class OutputFile {
 public:
  /// An existing file is an error.
  static Result<OutputFile> create(const std::filesystem::path& path);

  Result<void> write(std::string_view text);
  Result<void> write(std::span<const std::byte> bytes);
  /// On to the disk; the file stays.
  Result<void> close();
  const std::filesystem::path& path() const { return path_; }

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  OutputFile(std::FILE* file, const std::filesystem::path& path) : file_(file), path_(path), removal_(path) {}
  Error failure(int error_number) const;

  std::unique_ptr<std::FILE, Close> file_;
  std::filesystem::path path_;
  RemoveUnlessKept removal_;
};

/// An error when something is there already: to be asked before hours of work.
Result<void> require_absent(const std::filesystem::path& path);

/// A topic as part of a file name: "/camera0/image" -> "camera0_image".
std::string file_name_of(std::string_view topic);

/// A field of RFC 4180, quoted where it must be.
std::string csv_field(std::string_view text);

}  // namespace roseau::recorder
