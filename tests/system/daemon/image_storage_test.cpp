// Pictures stored as they came, losslessly coded, or lossy: what is found out from them must not depend on when they are looked
// at.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/system/daemon/program.h"

namespace roseau::testing {
namespace {

class ImageStorageTest : public ProgramTest {
 protected:
  std::string simulate_as(const std::string& storage, const std::string& name) const {
    const auto ran =
        run({"simulate", small_scene(), "-o", path(name), "--seconds", "3", "--seed", "7", "--image-storage", storage});
    EXPECT_EQ(ran.status, 0) << ran.err;
    return path(name);
  }
  nlohmann::json digest(const std::string& file) const {
    return run({"replay", file, "--max", "--headless", "--json"}).json()["digest"];
  }
};

TEST_F(ImageStorageTest, LosslessPicturesGiveTheResultsOfRawOnes) {
  const auto raw = simulate_as("raw", "raw.mcap");
  const auto png = simulate_as("png", "png.mcap");
  EXPECT_EQ(digest(raw), digest(png));
  EXPECT_LT(std::filesystem::file_size(png), std::filesystem::file_size(raw) * 3 / 4);
  EXPECT_EQ(run({"verify", png}).status, 0);
  const auto again = simulate_as("png", "again.mcap");
  EXPECT_TRUE(read_text_file(png) == read_text_file(again)) << "the files differ";
}

TEST_F(ImageStorageTest, LiveResultsAreThoseOfTheRecordingInEveryForm) {
  small_scene();
  for (const std::string storage : {"png", "jpeg"}) {
    const auto config = folder_.write(storage + ".toml", "[simulation]\nscene = 'scene.toml'\n[recording]\nimage_storage = '" +
                                                             storage + "'\njpeg_quality = 60\n");
    const auto live = run({"run", config, "--headless", "--record", path("rec_" + storage), "--for", "4", "--json"});
    ASSERT_EQ(live.status, 0) << live.err;
    const auto images = live.json()["streams"]["/camera0/image"];
    EXPECT_GT(images["recorded"], 60);
    EXPECT_EQ(images["recorded"], images["received"]);
    const auto recording = session_in(path("rec_" + storage));
    EXPECT_EQ(run({"verify", recording}).status, 0);
    EXPECT_NE(read_text_file(recording).find("foxglove.CompressedImage"), std::string::npos);
    EXPECT_EQ(live.json()["digest"], digest(recording)) << storage;
    // A recording of the replay holds the same files, so it gives the same again.
    const auto replayed = run({"replay", recording, "--max", "--headless", "--json", "--record", path("again_" + storage)});
    ASSERT_EQ(replayed.status, 0) << replayed.err;
    EXPECT_EQ(live.json()["digest"], digest(session_in(path("again_" + storage))));
  }
}

TEST_F(ImageStorageTest, UnknownStorageIsAnErrorThatNamesTheKey) {
  small_scene();
  const auto config = folder_.write("bad.toml", "[simulation]\nscene = 'scene.toml'\n[recording]\nimage_storage = 'gif'\n");
  const auto ran = run({"run", config, "--headless", "--for", "1"});
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find("image_storage"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("raw"), std::string::npos) << ran.err;
}

}  // namespace
}  // namespace roseau::testing
