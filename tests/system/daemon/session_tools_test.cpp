// The session tools as the evening after the storm uses them: the real program on a short simulated session.

#include <gmock/gmock.h>

#include <filesystem>

#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

using ::testing::HasSubstr;

class SessionToolsTest : public ProgramTest {
 protected:
  nlohmann::json done(std::vector<std::string> arguments) const {
    arguments.push_back("--json");
    const auto ran = run(std::move(arguments));
    EXPECT_EQ(ran.status, 0) << ran.err;
    return ran.json();
  }
  std::string digest(const std::string& file) const {
    return run({"replay", file, "--max", "--headless", "--json"}).json()["digest"];
  }
};

TEST_F(SessionToolsTest, CutsMergeToASessionThatReplaysTheSame) {
  const auto session = simulate("s.mcap", "4");
  const auto cut = done({"cut", session, "-o", path("a.mcap"), "--to", "2.5"});
  EXPECT_GT(cut["chunks_copied"], 5);
  EXPECT_TRUE(done({"cut", session, "-o", path("b.mcap"), "--from", "1.5"})["begins_in_mid_run"]);
  for (const char* part : {"a.mcap", "b.mcap"}) EXPECT_TRUE(done({"verify", path(part)})["whole"]) << part;
  EXPECT_EQ(digest(path("b.mcap")), digest(path("b.mcap"))) << "a cut replays";
  const auto merged = done({"merge", path("a.mcap"), path("b.mcap"), "-o", path("m.mcap")});
  EXPECT_GT(merged["duplicates"], 10);
  EXPECT_TRUE(done({"verify", path("m.mcap")})["whole"]);
  EXPECT_EQ(digest(path("m.mcap")), digest(session));
}

TEST_F(SessionToolsTest, InfoShowsATimeline) {
  const auto session = simulate("s.mcap", "3");
  const auto timeline = done({"info", session})["timeline"];
  const std::string line = timeline["lines"]["/camera0/image"];
  EXPECT_GT(line.size(), 20U);
  EXPECT_EQ(line.find(' '), std::string::npos) << "no slice without a picture: " << line;
  EXPECT_GE(timeline["marks"].size(), 1U) << "the scene's targets";
  EXPECT_THAT(run({"info", session}).out, HasSubstr("timeline, "));
}

TEST_F(SessionToolsTest, ExportsAreRead) {
  const auto session = simulate("s.mcap", "2");
  EXPECT_EQ(done({"export", session, "--csv", path("csv"), "--topic", "/truth/wind"})["streams"]["/truth/wind"]["rows"], 40);
  EXPECT_THAT(read_text_file(path("csv/truth_wind.csv")), HasSubstr("utc,time_s,arrival_s,sequence,status,u_mps"));
  done({"export", session, "--netcdf", path("o.nc"), "--topic", "/truth/wind"});
  if (std::filesystem::exists("/usr/bin/ncdump")) {
    Process process({"/usr/bin/ncdump", "-h", path("o.nc")}, folder_.path());
    EXPECT_EQ(process.wait(), 0);
    EXPECT_THAT(process.out(), HasSubstr("time = UNLIMITED ; // (40 currently)"));
    EXPECT_THAT(process.out(), HasSubstr("u_mps:units = \"m s-1\""));
    EXPECT_THAT(process.out(), HasSubstr(":Conventions = \"CF-1.8\""));
  }
  // A lossless video, imported again, has the same number of frames.
  done({"export", session, "--video", path("v.mkv"), "--topic", "/camera0/image"});
  const auto imported = done({"import", "-o", path("i.mcap"), "--video", path("v.mkv")});
  EXPECT_EQ(imported["streams"]["/camera0/image"]["samples"], 60);
}

TEST_F(SessionToolsTest, WrongUseAndErrorsAreSaid) {
  const auto session = simulate("s.mcap", "1");
  EXPECT_EQ(run({"export", session}).status, 2) << "no form";
  EXPECT_EQ(run({"export", session, "--csv", path("a"), "--toa5", path("b")}).status, 2) << "two forms";
  const auto ran = run({"cut", session, "-o", session});
  EXPECT_EQ(ran.status, 1);
  EXPECT_THAT(ran.err, HasSubstr("s.mcap"));
  EXPECT_THAT(run({"cut", session, "-o", path("c.mcap"), "--topic", "/nope"}).err, HasSubstr("/camera0/image"));
  EXPECT_FALSE(std::filesystem::exists(path("c.mcap")));
}

}  // namespace
}  // namespace roseau::testing
