// The page's files, read once at the start: small, so they stay in memory, and no path of a request ever reaches the disk.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "core/result.h"

namespace roseau::display {

struct StaticFile {
  std::string content;
  std::string content_type;
  std::string etag;  // quoted; a function of the content
};

class StaticFiles {
 public:
  StaticFiles() = default;
  /// Reads every file below `root`; not_found when it holds no index.html.
  static Result<StaticFiles> load(const std::filesystem::path& root);

  /// `target` as in the request line ("/", "/page.js?x=1"); "/" is index.html. Null when there is none.
  const StaticFile* find(std::string_view target) const;

 private:
  std::map<std::string, StaticFile, std::less<>> files_;  // by path, starting with '/'
};

/// The page's folder for the running program: ../share/roseau/web beside its bin folder, in the build tree and installed.
std::filesystem::path default_web_root();

}  // namespace roseau::display
