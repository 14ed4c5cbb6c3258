#include "structure/tree/tree_file.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>

#include "structure/tree/qsm.h"

namespace roseau::structure {

namespace {

constexpr std::uintmax_t kLargestFile_bytes = 512U << 20U;

Result<std::string> read_text(const std::filesystem::path& path) {
  std::error_code failure;
  const auto size = std::filesystem::file_size(path, failure);
  if (failure || !std::filesystem::is_regular_file(path)) {
    return Error{ErrorCode::not_found, path.string() + ": is no file; is the path right?"};
  }
  if (size > kLargestFile_bytes) return Error{ErrorCode::unsupported, path.string() + ": larger than 512 MB: no tree"};
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) return Error{ErrorCode::io, path.string() + ": cannot be read"};
  return text;
}

std::string lower_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return ending;
}

Result<ImportedTree> read_mtg_file(const std::filesystem::path& path, const TreeFileOptions& options) {
  const auto text = read_text(path);
  if (!text) return text.error();
  MtgOptions mtg = options.mtg;
  const auto dressing = options.dressing.value_or(std::filesystem::path(path).replace_extension(".drf"));
  if (options.dressing || (options.look_for_dressing && std::filesystem::exists(dressing))) {
    const auto dressing_text = read_text(dressing);
    if (!dressing_text) return dressing_text.error();
    if (auto applied = apply_dressing(*dressing_text, dressing.string(), mtg); !applied) return applied.error();
  }
  return read_mtg(*text, path.string(), mtg);
}

}  // namespace

Result<ImportedTree> read_tree(const std::filesystem::path& path, const TreeFileOptions& options) {
  const std::string ending = lower_ending(path);
  auto imported = [&]() -> Result<ImportedTree> {
    if (ending == ".mtg") return read_mtg_file(path, options);
    if (ending == ".mat") return read_qsm_mat(path);
    const auto text = read_text(path);
    if (!text) return text.error();
    return read_qsm_text(*text, path.string());
  }();
  if (imported) imported->tree.name = path.stem().string();
  return imported;
}

}  // namespace roseau::structure
