#include "recorder/tools/export/output_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace roseau::recorder {

Result<OutputFile> OutputFile::create(const std::filesystem::path& path) {
  std::FILE* file = std::fopen(path.c_str(), "wbxe");
  if (file != nullptr) return OutputFile(file, path);
  const int error_number = errno;
  if (error_number == EEXIST) {
    return Error{ErrorCode::invalid_argument, path.string() + " exists already and is not overwritten: give another name"};
  }
  return Error{ErrorCode::io, fmt::format("cannot make {}: {}", path.string(), std::strerror(error_number))};
}

Error OutputFile::failure(int error_number) const {
  const bool is_full = error_number == ENOSPC || error_number == EDQUOT;
  return {is_full ? ErrorCode::no_space : ErrorCode::io,
          fmt::format("cannot write {}: {}{}; the unfinished file was removed", path_.string(), std::strerror(error_number),
                      is_full ? " (free some space)" : "")};
}

Result<void> OutputFile::write(std::string_view text) { return write(std::as_bytes(std::span(text))); }

Result<void> OutputFile::write(std::span<const std::byte> bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) return failure(errno);
  return {};
}

Result<void> OutputFile::close() {
  if (std::fflush(file_.get()) != 0) return failure(errno);
  // Pipes and the like cannot be synced; disks say then that they are full.
  if (::fsync(::fileno(file_.get())) != 0 && errno != EINVAL && errno != EROFS) return failure(errno);
  if (std::fclose(file_.release()) != 0) return failure(errno);
  removal_.keep();
  return {};
}

Result<void> require_absent(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return {};
  return Error{ErrorCode::invalid_argument, path.string() + " exists already and is not overwritten: give another name"};
}

std::string file_name_of(std::string_view topic) {
  while (topic.starts_with('/')) topic.remove_prefix(1);
  std::string name(topic.empty() ? "stream" : topic);
  std::ranges::replace_if(
      name, [](unsigned char c) { return c < 0x80 && std::isalnum(c) == 0 && c != '-' && c != '.'; }, '_');
  return name;
}

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace roseau::recorder
