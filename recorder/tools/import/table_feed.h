// A table of values as a feed: what the rows mean is a RowMeaning's, when they were true is record_times.h's.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/sample.h"
#include "core/stream.h"
#include "recorder/tools/import/import_feed.h"
#include "recorder/tools/import/record_times.h"
#include "recorder/tools/import/table.h"

namespace roseau::recorder {

/// How rows become samples. Asked for every row, in order, several times over: restart() comes before each first row.
class RowMeaning {
 public:
  struct Item {
    std::size_t stream = 0;  // index into streams()
    Payload payload;
    std::uint16_t status = kStatusOk;
  };

  virtual ~RowMeaning() = default;
  virtual void restart() {}
  /// Adds the samples of the current row. Error: what is wrong with it, naming the place.
  virtual Result<void> read(const TableReader& row, std::vector<Item>& items) = 0;
  /// The streams, with all metadata but rate_hz and link, once every row was read.
  virtual std::vector<StreamInfo> streams() const = 0;
  /// For people; once every row was read.
  virtual std::vector<std::string> remarks() const = 0;
};

/// Reads the whole table twice or three times: to find what is wrong with it and how its times lie, and to hand it on.
/// Error: names the file, and the place where there is one.
Result<std::unique_ptr<ImportFeed>> make_table_feed(std::unique_ptr<TableReader> table, std::unique_ptr<RowMeaning> meaning,
                                                    std::optional<TimeColumns> time, std::optional<double> rate_hz,
                                                    Duration start_offset, const std::string& path);

}  // namespace roseau::recorder
