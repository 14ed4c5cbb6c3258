#include "structure/tree/mtg_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

namespace roseau::structure {

namespace {

constexpr std::int64_t kLargestIndex = 1'000'000'000;

std::string_view trimmed(std::string_view text) {
  const auto is_space = [](char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; };
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

/// The cells between tabs, each without spaces around it.
std::vector<std::string_view> cells_of(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0;;) {
    const auto end = line.find('\t', begin);
    cells.push_back(trimmed(line.substr(begin, end - begin)));
    if (end == std::string_view::npos) return cells;
    begin = end + 1;
  }
}

/// "MTG :" -> "MTG"; empty when the cell is no section's title.
std::string_view section_title(std::string_view cell) {
  if (cell.empty() || cell.back() != ':') return {};
  return trimmed(cell.substr(0, cell.size() - 1));
}

class Parser {
 public:
  Parser(std::string_view text, const std::string& source_name, const std::vector<std::string>& feature_names)
      : rest_(text), source_name_(source_name), feature_names_(feature_names) {}

  Result<MtgText> parse();

 private:
  using Cells = std::vector<std::string_view>;

  bool next_line();
  Error error(const std::string& what, ErrorCode code = ErrorCode::corrupt) const {
    return {code, fmt::format("{}:{}: {}", source_name_, line_number_, what)};
  }
  Error file_error(const std::string& what, ErrorCode code = ErrorCode::corrupt) const {
    return {code, source_name_ + ": " + what};
  }
  void note(std::string_view what) {
    const auto found = notes_.try_emplace(std::string(what), ImportNote{std::string(what), 0, line_number_});
    ++found.first->second.count;
  }

  Result<void> read_head(std::string_view title);
  Result<void> read_class();
  Result<void> read_description();
  Result<void> read_columns();
  Result<void> read_entity_line();
  Result<void> read_entities(std::string_view code, std::int32_t& at);
  Result<void> read_features(std::int32_t entity);

  Result<std::int32_t> symbol_of(std::string_view name) const;
  Result<std::int32_t> add(std::int32_t at, char relation, std::int32_t symbol, std::int64_t index);
  void note_label(MtgEntity& added);
  Result<void> skip_to(std::int32_t at, std::int32_t symbol, std::int64_t index);
  int scale_of(std::int32_t entity) const;
  std::int32_t finest(std::int32_t entity) const;
  MtgEntity& entity(std::int32_t i) { return mtg_.entities[static_cast<std::size_t>(i)]; }
  const MtgEntity& entity(std::int32_t i) const { return mtg_.entities[static_cast<std::size_t>(i)]; }

  std::string_view rest_;
  const std::string& source_name_;
  const std::vector<std::string>& feature_names_;

  std::string_view line_;
  Cells cells_;
  std::size_t line_number_ = 0;
  std::string_view section_;
  bool form_a_ = false;
  std::size_t entity_columns_ = 0;  // 0: the header has not come yet
  std::vector<std::size_t> feature_columns_;
  std::vector<std::int32_t> last_in_column_;
  bool later_plant_ = false;
  MtgText mtg_;
  std::vector<bool> has_successor_;
  std::map<std::tuple<std::int32_t, std::int32_t, std::int64_t>, std::int32_t> labels_;  // whole, symbol, index
  std::map<std::string, ImportNote> notes_;
};

/// Blank lines and comments are passed over.
bool Parser::next_line() {
  while (!rest_.empty()) {
    const auto end = rest_.find('\n');
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
    ++line_number_;
    line_ = line_.substr(0, line_.find('#'));
    if (trimmed(line_).empty()) continue;
    cells_ = cells_of(line_);
    return true;
  }
  return false;
}

Result<void> Parser::read_class() {
  const bool is_header = cells_[0] == "SYMBOL";
  if (is_header) return {};
  int scale = 0;
  const std::string_view digits = cells_.size() > 1 ? cells_[1] : std::string_view{};
  const auto [end, status] = std::from_chars(digits.data(), digits.data() + digits.size(), scale);
  if (status != std::errc() || end != digits.data() + digits.size() || scale < 0) {
    return error(fmt::format("class {}: the scale must be a whole number", cells_[0]));
  }
  if (scale > 0) mtg_.symbols.push_back({std::string(cells_[0]), scale});
  return {};
}

Result<void> Parser::read_description() {
  const bool is_header = cells_[0] == "LEFT";
  if (is_header || cells_.size() < 3 || cells_[2] == "+" || cells_[2] == "<") return {};
  return error(fmt::format("DESCRIPTION: unknown relation '{}': only + and < relate entities of one scale", cells_[2]));
}

/// One line of what comes before the entities.
Result<void> Parser::read_head(std::string_view title) {
  if (!title.empty()) {
    constexpr std::array kTitles = {"CODE", "CLASSES", "DESCRIPTION", "FEATURES", "MTG"};
    if (std::find(kTitles.begin(), kTitles.end(), title) == kTitles.end()) {
      return error(fmt::format("unknown section '{}'", title));
    }
    section_ = title;
    if (title != "CODE") return {};
    const auto form = std::find_if(cells_.begin() + 1, cells_.end(), [](auto cell) { return !cell.empty(); });
    form_a_ = form != cells_.end() && *form == "FORM-A";
    if (form_a_) return {};
    return error(fmt::format("CODE: {}: only FORM-A can be read", form != cells_.end() ? *form : ""), ErrorCode::unsupported);
  }
  if (section_ == "CLASSES") return read_class();
  if (section_ == "DESCRIPTION") return read_description();
  if (section_.empty()) return error("is not MTG text: it does not begin with a section such as CODE:");
  return {};
}

/// The header of the entities: columns without a name after ENTITY-CODE are entity columns as well.
Result<void> Parser::read_columns() {
  if (cells_[0] != "ENTITY-CODE" && cells_[0] != "TOPO") {
    return error("the line after MTG: must name the columns: ENTITY-CODE, tabs, then the features");
  }
  std::size_t column = 1;
  while (column < cells_.size() && cells_[column].empty()) ++column;
  entity_columns_ = column;
  last_in_column_.assign(entity_columns_, MtgEntity::kNone);
  for (const auto& name : feature_names_) {
    const auto found = std::find(cells_.begin() + static_cast<std::ptrdiff_t>(column), cells_.end(), name);
    feature_columns_.push_back(static_cast<std::size_t>(found - cells_.begin()));
    mtg_.has_column.push_back(found != cells_.end());
    if (found == cells_.end()) feature_columns_.back() = std::numeric_limits<std::size_t>::max();
  }
  return {};
}

Result<std::int32_t> Parser::symbol_of(std::string_view name) const {
  for (std::size_t i = 0; i < mtg_.symbols.size(); ++i) {
    if (mtg_.symbols[i].name == name) return static_cast<std::int32_t>(i);
  }
  return error(fmt::format("unknown class '{}': it is not listed under CLASSES", name));
}

int Parser::scale_of(std::int32_t i) const { return mtg_.symbols[static_cast<std::size_t>(entity(i).symbol)].scale; }

std::int32_t Parser::finest(std::int32_t i) const {
  while (entity(i).last_part != MtgEntity::kNone) i = entity(i).last_part;
  return i;
}

/// Numbering slips in the field (U3 after U3, a trunk that starts again at S10), so a label seen before is counted and
/// remembered; whether an axis really comes back to where it was, its positions tell.
void Parser::note_label(MtgEntity& added) {
  if (added.index == MtgEntity::kNoIndex || added.relation == '+' || added.whole == MtgEntity::kNone) return;
  const auto self = static_cast<std::int32_t>(mtg_.entities.size());
  const auto [place, is_new] = labels_.try_emplace({added.whole, added.symbol, added.index}, self);
  if (is_new) return;
  note("labels used twice within one entity");
  added.namesake = place->second;
}

/// A new entity that grows out of (or is a part of) `at`.
Result<std::int32_t> Parser::add(std::int32_t at, char relation, std::int32_t symbol, std::int64_t index) {
  MtgEntity added;
  added.line = line_number_;
  added.symbol = symbol;
  added.index = index;
  added.relation = relation;
  added.features.assign(feature_names_.size(), std::numeric_limits<double>::quiet_NaN());
  const int scale = mtg_.symbols[static_cast<std::size_t>(symbol)].scale;
  added.whole = at;
  while (added.whole != MtgEntity::kNone && scale_of(added.whole) >= scale) added.whole = entity(added.whole).whole;
  if (relation == '/') {
    added.from = added.whole;
    if (added.whole == MtgEntity::kNone && !mtg_.entities.empty()) {
      later_plant_ = true;
      return MtgEntity::kNone;
    }
  } else {
    if (at == MtgEntity::kNone) return error("the first entity must be a part of the whole: it begins with '/'");
    added.from = finest(at);
    if (relation == '<' && has_successor_[static_cast<std::size_t>(added.from)]) {
      note("second successors of one entity, taken for branches");
      added.relation = '+';
    }
  }
  note_label(added);
  const auto self = static_cast<std::int32_t>(mtg_.entities.size());
  if (added.relation == '<') has_successor_[static_cast<std::size_t>(added.from)] = true;
  if (added.whole != MtgEntity::kNone) entity(added.whole).last_part = self;
  mtg_.entities.push_back(std::move(added));
  has_successor_.push_back(false);
  return self;
}

/// "<<": the entities between need no places of their own, for nothing can refer to them.
Result<void> Parser::skip_to(std::int32_t at, std::int32_t symbol, std::int64_t index) {
  const MtgEntity& from = entity(at);
  if (from.symbol != symbol || from.index == MtgEntity::kNoIndex || index <= from.index) {
    return error(fmt::format("'<<' must lead from an entity to a later one of its class, not from {} to {}{}", mtg_.label(from),
                             mtg_.symbols[static_cast<std::size_t>(symbol)].name, index));
  }
  return {};
}

/// One cell, such as "^/A1/S1<S2+A3"; `at` is where it starts from and, afterwards, its last entity.
Result<void> Parser::read_entities(std::string_view code, std::int32_t& at) {
  while (!later_plant_) {
    code = trimmed(code);
    if (code.empty()) break;
    const char relation = code.front();
    if (relation != '/' && relation != '<' && relation != '+') {
      return error(fmt::format("unknown relation '{}': an entity begins with /, < or +", relation));
    }
    code.remove_prefix(1);
    const bool many = relation == '<' && (code.starts_with('<') || code.starts_with(".<"));
    if (many) code.remove_prefix(code.front() == '<' ? 1 : 2);
    const auto letters_end = std::find_if(code.begin(), code.end(),
                                          [](char c) { return std::isalpha(static_cast<unsigned char>(c)) == 0 && c != '_'; });
    const auto letters = static_cast<std::size_t>(letters_end - code.begin());
    const auto symbol = symbol_of(code.substr(0, letters));
    if (!symbol) return symbol.error();
    code.remove_prefix(letters);
    std::int64_t index = MtgEntity::kNoIndex;
    if (!code.empty() && code.front() != '-') {
      const auto [end, status] = std::from_chars(code.data(), code.data() + code.size(), index);
      if (status == std::errc::result_out_of_range || index > kLargestIndex) return error("an index above 1000000000");
      code.remove_prefix(static_cast<std::size_t>(end - code.data()));
    }
    const std::int64_t before = at == MtgEntity::kNone ? 0 : entity(at).index;
    if (many) {
      if (at == MtgEntity::kNone) return error("'<<' without an entity before it");
      if (auto valid = skip_to(at, *symbol, index); !valid) return valid.error();
    }
    const auto added = add(at, relation, *symbol, index);
    if (!added) return added.error();
    at = *added;
    if (many) entity(at).stands_for = static_cast<std::size_t>(index - before);
  }
  return {};
}

Result<void> Parser::read_features(std::int32_t i) {
  for (std::size_t k = 0; k < feature_columns_.size(); ++k) {
    if (feature_columns_[k] >= cells_.size() || cells_[feature_columns_[k]].empty()) continue;
    const std::string_view cell = cells_[feature_columns_[k]];
    double value = 0;
    const auto [end, status] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    if (status != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
      return error(fmt::format("{}: '{}' is no number", feature_names_[k], cell));
    }
    entity(i).features[k] = value;
  }
  return {};
}

Result<void> Parser::read_entity_line() {
  std::size_t column = 0;
  while (column < cells_.size() && cells_[column].empty()) ++column;
  if (column >= entity_columns_) return error("features without an entity, or an entity beyond the entity columns");
  std::string_view code = cells_[column];
  if (code.front() == '*') return error("entities with dates ('*') cannot be read", ErrorCode::unsupported);
  const bool goes_on = code.front() == '^';
  if (goes_on) code = trimmed(code.substr(1));
  if (code.empty()) return error("'^' without an entity after it");
  std::int32_t at = MtgEntity::kNone;
  if (goes_on || column > 0) {
    at = last_in_column_[goes_on ? column : column - 1];
    if (at == MtgEntity::kNone) {
      return error(goes_on ? "'^' goes on from an entity of its own column, and there is none"
                           : "no entity stands one column to the left of this one");
    }
  }
  if (auto read = read_entities(code, at); !read) return read.error();
  if (later_plant_) return {};
  last_in_column_[column] = at;
  std::fill(last_in_column_.begin() + static_cast<std::ptrdiff_t>(column) + 1, last_in_column_.end(), MtgEntity::kNone);
  return read_features(at);
}

Result<MtgText> Parser::parse() {
  while (next_line() && !later_plant_) {
    const std::string_view title = section_title(cells_[0]);
    Result<void> read;
    if (section_ != "MTG" || !title.empty()) {
      read = read_head(title);
    } else if (entity_columns_ == 0) {
      read = read_columns();
    } else {
      read = read_entity_line();
    }
    if (!read) return read.error();
  }
  if (!form_a_) return file_error("is not MTG text: it says nowhere CODE: FORM-A");
  if (mtg_.symbols.empty()) return file_error("lists no classes (section CLASSES:)");
  if (mtg_.entities.empty()) return file_error("holds no entity (section MTG:)");
  if (later_plant_) note("further plants, left out");
  for (auto& [what, counted] : notes_) mtg_.notes.push_back(std::move(counted));
  return std::move(mtg_);
}

}  // namespace

std::string MtgText::label(const MtgEntity& entity) const {
  const std::string& name = symbols[static_cast<std::size_t>(entity.symbol)].name;
  return entity.index == MtgEntity::kNoIndex ? name : name + std::to_string(entity.index);
}

Result<MtgText> parse_mtg(std::string_view text, const std::string& source_name,
                          const std::vector<std::string>& feature_names) {
  return Parser(text, source_name, feature_names).parse();
}

}  // namespace roseau::structure
