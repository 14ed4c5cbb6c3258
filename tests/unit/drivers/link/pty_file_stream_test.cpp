#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/link/file_stream.h"
#include "drivers/link/pty_stream.h"
#include "drivers/link/serial_stream.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/drivers/link/stream_support.h"

namespace roseau::link {
namespace {

using roseau::testing::TemporaryFolder;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

TEST(PtyStream, KeepsALinkWhileItIsOpen) {
  const TemporaryFolder folder;
  const auto link_path = (folder.path() / "sonic").string();
  PtyStream instrument(link_path);
  ASSERT_TRUE(instrument.open());
  EXPECT_EQ(std::filesystem::read_symlink(link_path), instrument.port_path());
  SerialStream port(link_path, {});
  ASSERT_TRUE(port.open());
  ASSERT_TRUE(instrument.write(bytes_of("through the link")));
  EXPECT_EQ(read_text(port, 16), "through the link");
  instrument.close();
  EXPECT_FALSE(std::filesystem::is_symlink(link_path));
}

TEST(PtyStream, ReplacesAStaleLinkButNoFile) {
  const TemporaryFolder folder;
  const auto link_path = folder.path() / "sonic";
  std::filesystem::create_symlink("/dev/pts/99999", link_path);
  EXPECT_TRUE(PtyStream(link_path.string()).open());
  const auto file_path = folder.write("precious", "data");
  PtyStream over_file(file_path);
  const auto opened = over_file.open();
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message, HasSubstr("would replace a file"));
  EXPECT_TRUE(std::filesystem::is_regular_file(file_path));
}

TEST(PtyStream, LosesBytesWhileNobodyListensAndServesTheNextReader) {
  PtyStream instrument;
  ASSERT_TRUE(instrument.open());
  const std::string old_record(100'000, 'o');  // more than the terminal could hold back
  ASSERT_TRUE(instrument.write(bytes_of(old_record)));
  for (const char* record : {"first reader", "second reader"}) {
    SerialStream port(instrument.port_path(), {});
    ASSERT_TRUE(port.open());
    ASSERT_TRUE(instrument.write(bytes_of(record)));
    EXPECT_EQ(read_text(port, std::string(record).size()), record);
    port.close();
    std::array<std::byte, 8> buffer{};
    EXPECT_TRUE(instrument.read(buffer, milliseconds{1}));
  }
}

TEST(FileStream, PlaysItsBytesAtTheStatedRateAndFinishes) {
  const TemporaryFolder folder;
  FileStream file(folder.write("capture", "0123456789"), milliseconds{1});
  ASSERT_TRUE(file.open());
  std::array<std::byte, 4> buffer{};
  const auto first = file.read(buffer, milliseconds{0});
  const auto second = file.read(buffer, milliseconds{0});
  const auto third = file.read(buffer, milliseconds{0});
  ASSERT_TRUE(first && second && third);
  EXPECT_EQ(first->size + second->size + third->size, 10U);
  EXPECT_EQ(second->first_byte_time - first->first_byte_time, milliseconds{4});
  EXPECT_EQ(third->first_byte_time - first->first_byte_time, milliseconds{8});
  EXPECT_FALSE(third->finished);
  const auto end = file.read(buffer, milliseconds{0});
  ASSERT_TRUE(end);
  EXPECT_TRUE(end->finished);
}

TEST(FileStream, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  const auto missing = FileStream((folder.path() / "missing").string(), Duration{0}).open();
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::not_found);
  EXPECT_THAT(missing.error().message, HasSubstr("missing"));
  const auto not_a_file = FileStream(folder.path().string(), Duration{0}).open();
  ASSERT_FALSE(not_a_file);
  EXPECT_THAT(not_a_file.error().message, HasSubstr("is a folder"));
  FileStream file(folder.write("capture", "x"), Duration{0});
  ASSERT_TRUE(file.open());
  EXPECT_FALSE(file.write(bytes_of("command")));
}

}  // namespace
}  // namespace roseau::link
