#include "display/static_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace roseau::display {
namespace {

void write(const std::filesystem::path& path, const std::string& content) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
}

TEST(StaticFiles, ServesWhatIsThere) {
  const testing::TemporaryFolder folder;
  write(folder.path() / "index.html", "<html>");
  write(folder.path() / "sub" / "page.js", "code");
  const auto files = StaticFiles::load(folder.path());
  ASSERT_TRUE(files);
  ASSERT_NE(files->find("/"), nullptr);
  EXPECT_EQ(files->find("/")->content, "<html>");
  EXPECT_EQ(files->find("/index.html?x=1"), files->find("/"));
  ASSERT_NE(files->find("/sub/page.js"), nullptr);
  EXPECT_THAT(files->find("/sub/page.js")->content_type, ::testing::StartsWith("text/javascript"));
}

TEST(StaticFiles, ServesNothingElse) {
  const testing::TemporaryFolder folder;
  write(folder.path() / "web" / "index.html", "<html>");
  write(folder.path() / "secret", "secret");
  const auto files = StaticFiles::load(folder.path() / "web");
  ASSERT_TRUE(files);
  for (const char* target : {"/../secret", "/%2e%2e/secret", "secret", "", "//", "/sub/../index.html"}) {
    EXPECT_EQ(files->find(target), nullptr) << target;
  }
}

TEST(StaticFiles, TagsFollowTheContent) {
  const testing::TemporaryFolder folder;
  write(folder.path() / "index.html", "one");
  const auto first = StaticFiles::load(folder.path());
  const auto again = StaticFiles::load(folder.path());
  write(folder.path() / "index.html", "two");
  const auto changed = StaticFiles::load(folder.path());
  EXPECT_EQ(first->find("/")->etag, again->find("/")->etag);
  EXPECT_NE(first->find("/")->etag, changed->find("/")->etag);
  EXPECT_EQ(first->find("/")->etag.size(), 18U);
}

TEST(StaticFiles, SaysWhereThePageShouldBe) {
  const testing::TemporaryFolder folder;
  const auto files = StaticFiles::load(folder.path() / "absent");
  ASSERT_FALSE(files);
  EXPECT_EQ(files.error().code, ErrorCode::not_found);
  EXPECT_THAT(files.error().message, ::testing::HasSubstr("absent"));
}

}  // namespace
}  // namespace roseau::display
