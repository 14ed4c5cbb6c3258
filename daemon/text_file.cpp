#include "daemon/text_file.h"

#include <fstream>
#include <sstream>

namespace roseau::daemon {

Result<std::string> read_text_file(const std::filesystem::path& path) {
  const std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::not_found, path.string() + ": cannot be read; is the path right?"};
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace roseau::daemon
