#include "recorder/tools/import/byte_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <utility>

namespace roseau::recorder {

namespace {

class PlainFile : public ByteSource {
 public:
  PlainFile(std::ifstream file, std::string path, std::uint64_t size)
      : file_(std::move(file)), path_(std::move(path)), size_(size) {}

  Result<std::size_t> read(std::span<char> into) override {
    file_.read(into.data(), static_cast<std::streamsize>(into.size()));
    if (file_.bad()) return Error{ErrorCode::io, path_ + " cannot be read: check the disk"};
    return static_cast<std::size_t>(file_.gcount());
  }
  Result<void> rewind() override {
    file_.clear();
    file_.seekg(0);
    if (!file_)
      return Error{ErrorCode::io, path_ + " cannot be read from its beginning: is it a pipe? Save it as a file first"};
    return {};
  }
  std::uint64_t size() const override { return size_; }

 private:
  std::ifstream file_;
  std::string path_;
  std::uint64_t size_;
};

class MemorySource : public ByteSource {
 public:
  explicit MemorySource(std::string bytes) : bytes_(std::move(bytes)) {}

  Result<std::size_t> read(std::span<char> into) override {
    const auto count = std::min(into.size(), bytes_.size() - next_);
    std::copy_n(bytes_.data() + next_, count, into.data());
    next_ += count;
    return count;
  }
  Result<void> rewind() override {
    next_ = 0;
    return {};
  }
  std::uint64_t size() const override { return bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t next_ = 0;
};

}  // namespace

Result<std::unique_ptr<ByteSource>> open_file(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return Error{ErrorCode::not_found, path + " does not exist: check its path"};
  if (std::filesystem::is_directory(path, error))
    return Error{ErrorCode::invalid_argument, path + " is a folder: name a file in it"};
  std::ifstream file(path, std::ios::binary);
  const auto size = std::filesystem::file_size(path, error);
  if (!file || error) return Error{ErrorCode::io, path + " cannot be read: check that you may"};
  return std::unique_ptr<ByteSource>(std::make_unique<PlainFile>(std::move(file), path, size));
}

std::unique_ptr<ByteSource> memory_source(std::string bytes) { return std::make_unique<MemorySource>(std::move(bytes)); }

FileReader::FileReader(std::unique_ptr<ByteSource> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)), buffer_(kBufferBytes) {}

double FileReader::share() const {
  return size() == 0 ? 1.0 : std::min(1.0, static_cast<double>(position_) / static_cast<double>(size()));
}

Result<void> FileReader::rewind() {
  begin_ = end_ = 0;
  at_end_ = false;
  line_had_end_ = true;
  position_ = 0;
  line_number_ = 0;
  return source_->rewind();
}

// Until `count` bytes are there, or the file ends.
Result<void> FileReader::fill(std::size_t count) {
  while (end_ - begin_ < count && !at_end_) {
    if (begin_ > 0) {
      std::copy(buffer_.begin() + static_cast<std::ptrdiff_t>(begin_), buffer_.begin() + static_cast<std::ptrdiff_t>(end_),
                buffer_.begin());
      end_ -= std::exchange(begin_, 0);
    }
    const auto got = source_->read(std::span(buffer_).subspan(end_));
    if (!got) return got.error();
    at_end_ = *got == 0;
    end_ += *got;
  }
  return {};
}

Result<std::string_view> FileReader::peek(std::size_t count) {
  ROSEAU_CHECK(count <= kLongestLine);
  if (auto filled = fill(count); !filled) return filled.error();
  return std::string_view(buffer_.data() + begin_, std::min(count, end_ - begin_));
}

Result<std::string_view> FileReader::take(std::size_t count) {
  const auto bytes = peek(count);
  if (!bytes) return bytes.error();
  begin_ += bytes->size();
  position_ += bytes->size();
  return *bytes;
}

Result<std::optional<std::string_view>> FileReader::line() {
  // Mostly the line is in the buffer already.
  const auto find_end = [&] {
    return std::string_view(buffer_.data() + begin_, end_ - begin_).substr(0, kLongestLine).find('\n');
  };
  auto length = find_end();
  if (length == std::string_view::npos) {
    if (auto filled = fill(kLongestLine); !filled) return filled.error();
    length = find_end();
  }
  if (length == std::string_view::npos && end_ - begin_ >= kLongestLine) {
    return Error{ErrorCode::corrupt, fmt::format("{}:{}: a line of more than {} bytes: is this a text file?", name_,
                                                 line_number_ + 1, kLongestLine)};
  }
  if (begin_ == end_) return std::optional<std::string_view>();
  line_had_end_ = length != std::string_view::npos;
  std::string_view text(buffer_.data() + begin_, line_had_end_ ? length : end_ - begin_);
  begin_ += text.size() + (line_had_end_ ? 1 : 0);
  position_ += text.size() + (line_had_end_ ? 1 : 0);
  ++line_number_;
  if (text.ends_with('\r')) text.remove_suffix(1);
  return std::optional(text);
}

}  // namespace roseau::recorder
