#include "display/static_files.h"

#include <array>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

namespace roseau::display {

namespace {

namespace fs = std::filesystem;

std::string content_type_of(const fs::path& path) {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kTypes = {{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
      {".png", "image/png"},
      {".json", "application/json"},
      {".map", "application/json"},
      {".txt", "text/plain; charset=utf-8"},
  }};
  const std::string extension = path.extension().string();
  for (const auto& [known, type] : kTypes) {
    if (known == extension) return std::string(type);
  }
  return "application/octet-stream";
}

/// FNV-1a, 64 bits: tells one build of the page from another, nothing more.
std::string etag_of(std::string_view content) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : content) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  static constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text(18, '"');
  for (std::size_t digit = 0; digit < 16; ++digit) text[digit + 1] = kDigits[(hash >> (60 - 4 * digit)) & 0xf];
  return text;
}

}  // namespace

Result<StaticFiles> StaticFiles::load(const fs::path& root) {
  StaticFiles files;
  std::error_code error;
  for (fs::recursive_directory_iterator it(root, error), end; !error && it != end; it.increment(error)) {
    if (!it->is_regular_file()) continue;
    std::ifstream stream(it->path(), std::ios::binary);
    std::string content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    if (!stream) return Error{ErrorCode::io, "cannot read " + it->path().string()};
    std::string etag = etag_of(content);
    const fs::path name = fs::path("/") / it->path().lexically_relative(root);
    files.files_[name.generic_string()] = StaticFile{std::move(content), content_type_of(it->path()), std::move(etag)};
  }
  if (error || !files.files_.contains("/index.html")) {
    return Error{ErrorCode::not_found, "the page is not in " + root.string() + ": build it (./dev build), or install roseau"};
  }
  return files;
}

const StaticFile* StaticFiles::find(std::string_view target) const {
  const std::string_view path = target.substr(0, target.find_first_of("?#"));
  const auto found = files_.find(path == "/" ? std::string_view("/index.html") : path);
  return found == files_.end() ? nullptr : &found->second;
}

fs::path default_web_root() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return program.parent_path().parent_path() / "share" / "roseau" / "web";
}

}  // namespace roseau::display
