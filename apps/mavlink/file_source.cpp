// The files of the vehicle: their names, and their bytes.
#include "file_source.hpp"

#include <algorithm>
#include <array>

namespace stator::apps::mavlink {

namespace {

using Kind = File::Kind;

struct Row {
    Folder folder;
    std::string_view name;
    Folder is_folder;  // none: it is a file
    Kind kind;
};

constexpr std::array kTree{
    Row{Folder::kRoot, "@PARAM", Folder::kParameters, Kind::kNone},
    Row{Folder::kRoot, "etc", Folder::kMetadata, Kind::kNone},
    Row{Folder::kRoot, "log", Folder::kLogs, Kind::kNone},
    Row{Folder::kParameters, "param.pck", Folder::kNone, Kind::kParameters},
    Row{Folder::kMetadata, "general.json", Folder::kNone, Kind::kGeneral},
    Row{Folder::kMetadata, "parameters.json.xz", Folder::kNone, Kind::kDescribed},
};

// Names of logs. No board has more than some.
constexpr std::array<std::string_view, 10> kLogs{"0.ulg", "1.ulg", "2.ulg", "3.ulg", "4.ulg",
                                                 "5.ulg", "6.ulg", "7.ulg", "8.ulg", "9.ulg"};

std::string_view without_slashes(std::string_view path) {
    while (path.starts_with('/')) path.remove_prefix(1);
    while (path.ends_with('/')) path.remove_suffix(1);
    return path;
}

const Row* find_row(Folder folder, std::string_view name) {
    for (const Row& row : kTree) {
        if (row.folder == folder && row.name == name) return &row;
    }
    return nullptr;
}

// Takes what lies before `mark` out of `text`, and the mark.
std::string_view take_until(std::string_view& text, char mark) {
    const std::string_view part(text.data(), std::min(text.find(mark), text.size()));
    text.remove_prefix(std::min(part.size() + 1, text.size()));
    return part;
}

// The number that follows `key`, if it is written there; false: it is not one of 16 bits.
bool read_number(std::string_view query, std::string_view key, uint16_t& number) {
    const std::size_t at = query.find(key);
    if (at == std::string_view::npos) return true;
    uint32_t value = 0;
    query.remove_prefix(at + key.size());
    const std::string_view digits = take_until(query, '&');
    if (digits.empty()) return false;
    for (const char digit : digits) {
        if (digit < '0' || digit > '9') return false;
        value = value * 10 + static_cast<uint32_t>(digit - '0');
        if (value > UINT16_MAX) return false;
    }
    number = static_cast<uint16_t>(value);
    return true;
}

// `withdefaults=1&start=N&count=N`, each of them or none.
File with_query(File file, std::string_view query) {
    uint16_t defaults = 0;
    const bool is_read = read_number(query, "withdefaults=", defaults) &&
                         read_number(query, "start=", file.first) &&
                         read_number(query, "count=", file.count);
    file.with_defaults = defaults != 0;
    if (file.count == 0) file.count = UINT16_MAX;  // as ArduPilot has it: all
    return is_read ? file : File{};
}

}  // namespace

Folder find_folder(std::string_view path) {
    path = without_slashes(path);
    if (path.empty() || path == ".") return Folder::kRoot;
    const Row* const row = find_row(Folder::kRoot, path);
    return row == nullptr ? Folder::kNone : row->is_folder;
}

File find_file(std::string_view path) {
    std::string_view query = path;
    std::string_view name = without_slashes(take_until(query, '?'));
    const Folder folder = find_folder(take_until(name, '/'));
    if (folder == Folder::kLogs) {
        const auto* const log = std::ranges::find(kLogs, name);
        if (log == kLogs.end()) return {};
        return {.kind = Kind::kLog, .log = static_cast<uint16_t>(log - kLogs.begin())};
    }
    const Row* const row = find_row(folder, name);
    if (row == nullptr) return {};
    const File file{.kind = row->kind};
    return file.kind == Kind::kParameters ? with_query(file, query) : file;
}

Entry entry_of(Folder folder, uint32_t index) {
    if (folder == Folder::kLogs) {
        if (index >= kLogs.size()) return {};
        return {kLogs[index], {.kind = Kind::kLog, .log = static_cast<uint16_t>(index)}};
    }
    for (const Row& row : kTree) {
        if (row.folder == folder && index-- == 0) return {row.name, {.kind = row.kind}};
    }
    return {};
}

void FileSource::ask(const Wish& wish, MavlinkPorts& ports) {
    is_asked_ = true;
    wish_ = wish;
    asked_us_ = ports.now;
    ++tag_;
    if (wish.file.kind != Kind::kParameters && wish.file.kind != Kind::kLog) return;
    using Asked = FileRequest::File;
    ports.file_request.publish([&] {
        return FileRequest{.tag = tag_,
                           .file = wish.file.kind == Kind::kLog ? Asked::kLog : Asked::kParameters,
                           .log = wish.file.log,
                           .offset = wish.offset,
                           .length = wish.length,
                           .with_defaults = wish.file.with_defaults,
                           .first = wish.file.first,
                           .count = wish.file.count};
    });
}

bool FileSource::take_answer(MavlinkPorts& ports, FilePiece& piece) {
    const bool is_constant =
        wish_.file.kind == Kind::kGeneral || wish_.file.kind == Kind::kDescribed;
    if (is_asked_ && is_constant) {
        is_asked_ = false;
        piece = {.result = FilePiece::Result::kAbsent};
        if (ports.metadata == nullptr) return true;
        const MetadataFile& file = wish_.file.kind == Kind::kGeneral ? ports.metadata->general
                                                                     : ports.metadata->parameters;
        const uint32_t begin = std::min(wish_.offset, file.bytes);
        const auto bytes = file.all().subspan(
            begin, std::min<std::size_t>({wish_.length, piece.data.size(), file.bytes - begin}));
        std::ranges::copy(bytes, piece.data.begin());
        piece.result = FilePiece::Result::kRead;
        piece.length = static_cast<uint8_t>(bytes.size());
        piece.bytes = file.bytes;
        return true;
    }
    for (const auto* from : {&ports.parameter_file, &ports.log_file}) {
        if (!is_asked_ || !from->is_new() || (*from)->tag != tag_) continue;
        piece = **from;
        is_asked_ = false;
        return true;
    }
    if (is_asked_ && ports.now - asked_us_ > kPatience_us) {
        is_asked_ = false;
        piece = {.result = FilePiece::Result::kAbsent};
        return true;
    }
    return false;
}

}  // namespace stator::apps::mavlink
