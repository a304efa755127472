// Messages of the log, and the lines that define what the recorded numbers mean.
#include "recording.hpp"

#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>
#include <string_view>

namespace stator::replay {

namespace {

constexpr size_t kFileHead = 16;
constexpr size_t kMessageHead = 3;  // size and type
constexpr char kRecording = 'X';
// In front of what is among the definitions of the log.
constexpr std::string_view kPacked{"M\0\x10stator recording", 19};
constexpr unsigned kStream = 0x00;
constexpr unsigned kDefinition = 0x10;
constexpr unsigned kGap = 0x20;

bool read_file(const char* path, std::vector<uint8_t>& bytes) {
    std::FILE* file = std::fopen(path, "rb");
    if (file == nullptr) return false;
    std::array<uint8_t, 65536> part{};
    for (size_t count = 0; (count = std::fread(part.data(), 1, part.size(), file)) != 0;) {
        bytes.insert(bytes.end(), part.begin(), part.begin() + static_cast<ptrdiff_t>(count));
    }
    const bool is_whole = std::ferror(file) == 0;
    std::fclose(file);
    return is_whole;
}

// Bytes of a message, of its fields as ULog spells them: "uint64_t timestamp;float[3] xyz;".
size_t bytes_of(const std::string& layout) {
    static const std::map<std::string, size_t, std::less<>> kSizes{
        {"bool", 1},     {"int8_t", 1},  {"uint8_t", 1},  {"int16_t", 2},
        {"uint16_t", 2}, {"int32_t", 4}, {"uint32_t", 4}, {"int64_t", 8},
        {"uint64_t", 8}, {"float", 4},   {"double", 8}};
    size_t total = 0;
    std::istringstream fields(layout);
    for (std::string field; std::getline(fields, field, ';');) {
        const std::string type = field.substr(0, field.find(' '));
        const size_t bracket = type.find('[');
        const size_t count = bracket == std::string::npos
                                 ? 1
                                 : std::strtoul(type.c_str() + bracket + 1, nullptr, 10);
        const auto found = kSizes.find(type.substr(0, bracket));
        if (found != kSizes.end()) total += found->second * count;
    }
    return total;
}

class Definitions {
  public:
    explicit Definitions(Recording& recording) : recording_(recording) {}

    bool add(const std::string& line) {
        std::istringstream words(line);
        std::string what;
        words >> what;
        if (what == "modes") recording_.has_modes = true;
        if (what == "topic") return add_topic(words);
        if (what == "task") return add_task(words);
        return true;
    }

  private:
    bool add_topic(std::istringstream& words) {
        TopicRow row;
        std::string layout;
        words >> row.name >> std::ws;
        std::getline(words, layout);
        row.bytes = bytes_of(layout);
        index_[row.name] = recording_.topics.size();
        recording_.topics.push_back(row);
        return true;
    }

    bool add_task(std::istringstream& words) {
        static const std::map<std::string, Kind> kKinds{{"app", Kind::kApp},
                                                        {"driver", Kind::kDriver},
                                                        {"logger", Kind::kLogger},
                                                        {"parameters", Kind::kParameters}};
        TaskRow row;
        std::string kind;
        std::string inputs;
        std::string outputs;
        words >> row.name >> row.level >> kind >> inputs >> outputs;
        const auto found = kKinds.find(kind);
        if (words.fail() || found == kKinds.end() || row.level >= kStreams) return false;
        row.kind = found->second;
        if (!add_ports(row, inputs, true) || !add_ports(row, outputs, false)) return false;
        recording_.tasks.push_back(row);
        return true;
    }

    // "name:topic:kind,...", or "-".
    bool add_ports(TaskRow& row, const std::string& text, bool is_input) {
        if (text == "-") return true;
        std::istringstream ports(text);
        for (std::string port; std::getline(ports, port, ',');) {
            std::istringstream parts(port);
            std::string name;
            std::string topic;
            std::string kind;
            std::getline(parts, name, ':');
            std::getline(parts, topic, ':');
            std::getline(parts, kind, ':');
            const auto found = index_.find(topic);
            if (found == index_.end()) return false;
            row.ports.push_back({.topic = found->second,
                                 .is_input = is_input,
                                 .is_cursor = kind == "trigger" || kind == "queue",
                                 .is_whole = kind == "whole",
                                 .is_stamp = kind == "stamp"});
        }
        return true;
    }

    Recording& recording_;
    std::map<std::string, size_t> index_;
};

}  // namespace

std::optional<Recording> read_recording(const char* log, size_t count) {
    std::vector<uint8_t> bytes;
    if (!read_file(log, bytes) || bytes.size() < count) return std::nullopt;
    bytes.resize(count);
    Recording recording;
    Definitions definitions(recording);
    for (size_t at = kFileHead; at + kMessageHead < bytes.size();) {
        const size_t end = at + kMessageHead + bytes[at] + size_t{256} * bytes[at + 1];
        const std::string_view rest{reinterpret_cast<const char*>(bytes.data()) + at + 2,
                                    bytes.size() - at - 2};
        const bool is_packed = rest.starts_with(kPacked);
        const size_t begin = at + 2 + (is_packed ? kPacked.size() : 1);
        at = end;
        if (!is_packed && rest.front() != kRecording) continue;
        if (begin >= end || end > bytes.size()) continue;
        const uint8_t* content = bytes.data() + begin;
        const size_t size = end - begin;
        const unsigned kind = content[0] & 0xF0U;
        const unsigned level = content[0] & 0x0FU;
        if (kind == kStream) {
            auto& stream = recording.streams[level];
            stream.insert(stream.end(), content + 1, content + size);
        } else if (kind == kGap) {
            recording.has_gap[level] = true;
        } else if (kind == kDefinition) {
            const auto* text = reinterpret_cast<const char*>(content + 1);
            if (!definitions.add(std::string(text, size - 1))) return std::nullopt;
        }
    }
    return recording;
}

uint64_t Reader::number() {
    uint64_t value = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
        const uint8_t* byte = skip(1);
        if (byte == nullptr) return 0;
        value |= uint64_t{*byte & 0x7FU} << shift;
        if ((*byte & 0x80U) == 0) return value;
    }
    is_past_end_ = true;  // no number is that long
    return 0;
}

uint32_t Reader::word() {
    uint32_t value = 0;
    const uint8_t* from = skip(sizeof value);
    if (from != nullptr) std::memcpy(&value, from, sizeof value);
    return value;
}

const uint8_t* Reader::skip(size_t count) {
    is_past_end_ = is_past_end_ || bytes_->size() - at_ < count;
    if (is_past_end_) return nullptr;
    at_ += count;
    return bytes_->data() + at_ - count;
}

}  // namespace stator::replay
