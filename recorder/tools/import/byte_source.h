// Files as they are read by an import: from the beginning to the end, several times, never whole in memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace roseau::recorder {

class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// Fills `into` from its beginning; fewer bytes, at last none, only at the end. Error: names the file.
  virtual Result<std::size_t> read(std::span<char> into) = 0;
  virtual Result<void> rewind() = 0;
  virtual std::uint64_t size() const = 0;
};

/// Error: not there, a folder, or not readable, naming the path.
Result<std::unique_ptr<ByteSource>> open_file(const std::string& path);

std::unique_ptr<ByteSource> memory_source(std::string bytes);

/// Lines and blocks of a source, through a buffer of kBufferBytes.
class FileReader {
 public:
  static constexpr std::size_t kBufferBytes = std::size_t{1} << 18U;
  static constexpr std::size_t kLongestLine = std::size_t{1} << 16U;

  FileReader(std::unique_ptr<ByteSource> source, std::string name);

  const std::string& name() const { return name_; }
  std::uint64_t size() const { return source_->size(); }
  std::uint64_t position() const { return position_; }
  /// How much has been read, 0 to 1.
  double share() const;

  Result<void> rewind();

  /// The next `count` bytes, at most kLongestLine, without taking them; fewer only at the end. Valid until the next call.
  Result<std::string_view> peek(std::size_t count);
  /// As peek, and takes them.
  Result<std::string_view> take(std::size_t count);

  /// The next line without its end (LF, CR LF); nothing behind the last. Error: longer than kLongestLine.
  Result<std::optional<std::string_view>> line();
  /// False: the file ended before the last line() did.
  bool line_had_end() const { return line_had_end_; }
  std::size_t line_number() const { return line_number_; }  // of the last line()

 private:
  Result<void> fill(std::size_t count);

  std::unique_ptr<ByteSource> source_;
  std::string name_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool at_end_ = false;
  bool line_had_end_ = true;
  std::uint64_t position_ = 0;
  std::size_t line_number_ = 0;
};

}  // namespace roseau::recorder
