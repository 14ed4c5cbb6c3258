#include "recorder/tools/import/ghg_archive.h"

#include <fmt/format.h>
#include <zip.h>

#include <optional>
#include <utility>

namespace roseau::recorder {

namespace {

struct Closer {
  void operator()(zip_t* archive) const { zip_discard(archive); }
  void operator()(zip_file_t* file) const { zip_fclose(file); }
};

// The bytes of one member. What is unpacked is not bounded by what the archive declares, but never kept either.
class Member : public ByteSource {
 public:
  Member(std::unique_ptr<zip_t, Closer> archive, zip_uint64_t index, std::uint64_t size, std::string name)
      : archive_(std::move(archive)), index_(index), size_(size), name_(std::move(name)) {}

  Result<void> rewind() override {
    file_.reset(zip_fopen_index(archive_.get(), index_, 0));
    if (file_ == nullptr) return Error{ErrorCode::corrupt, fmt::format("{}: {}", name_, zip_strerror(archive_.get()))};
    read_ = 0;
    return {};
  }
  Result<std::size_t> read(std::span<char> into) override {
    const auto count = zip_fread(file_.get(), into.data(), into.size());
    if (count < 0)
      return Error{ErrorCode::corrupt, fmt::format("{} cannot be unpacked: {}", name_, zip_file_strerror(file_.get()))};
    read_ += static_cast<std::uint64_t>(count);
    if (read_ > size_)
      return Error{ErrorCode::corrupt, fmt::format("{} unpacks to more than the {} bytes it declares", name_, size_)};
    return static_cast<std::size_t>(count);
  }
  std::uint64_t size() const override { return size_; }

 private:
  std::unique_ptr<zip_t, Closer> archive_;
  zip_uint64_t index_;
  std::uint64_t size_;
  std::uint64_t read_ = 0;
  std::string name_;
  std::unique_ptr<zip_file_t, Closer> file_;
};

bool is_data(std::string_view name) { return name.ends_with(".data") && !name.ends_with("-biomet.data"); }

}  // namespace

Result<std::unique_ptr<ByteSource>> open_ghg_archive(const std::string& path) {
  int code = 0;
  std::unique_ptr<zip_t, Closer> archive(zip_open(path.c_str(), ZIP_RDONLY, &code));
  if (archive == nullptr)
    return Error{ErrorCode::corrupt, fmt::format("{} is no zip archive that can be read (code {}): copy it again", path, code)};
  std::optional<zip_uint64_t> index;
  const auto count = zip_get_num_entries(archive.get(), 0);
  for (zip_int64_t i = 0; i < count; ++i) {
    const char* name = zip_get_name(archive.get(), static_cast<zip_uint64_t>(i), 0);
    if (name == nullptr || !is_data(name)) continue;
    if (index) return Error{ErrorCode::corrupt, path + ": holds several .data files: unpack it and import one of them"};
    index = static_cast<zip_uint64_t>(i);
  }
  if (!index) return Error{ErrorCode::corrupt, path + ": holds no .data file: is this a GHG archive?"};
  zip_stat_t about{};
  if (zip_stat_index(archive.get(), *index, 0, &about) != 0)
    return Error{ErrorCode::corrupt, fmt::format("{}: {}", path, zip_strerror(archive.get()))};
  auto member = std::make_unique<Member>(std::move(archive), *index, about.size, path);
  if (auto opened = member->rewind(); !opened) return opened.error();
  return std::unique_ptr<ByteSource>(std::move(member));
}

}  // namespace roseau::recorder
