// Definitions, samples and blocks; formats of messages as the ULog file format has them.
#include "logger.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

namespace stator::apps::logger {

namespace {

using namespace std::literals::string_view_literals;

// "ULog", 0x01 0x12 0x35, version 1, then the start time: 0, as the clock counts from boot.
constexpr std::array<uint8_t, 16> kHeader{0x55, 0x4C, 0x6F, 0x67, 0x01, 0x12, 0x35, 0x01};
constexpr size_t kFlagBytes = 40;
constexpr uint8_t kConfigurationDefault = 1U << 1U;

std::string_view type_of(const LogParameter& parameter) {
    return parameter.is_float ? "float "sv : "int32_t "sv;
}

// By words at any address: the library copies what is not aligned byte by byte.
void copy(uint8_t* to, const uint8_t* from, size_t count) {
    size_t i = 0;
    for (; i + sizeof(uint32_t) <= count; i += sizeof(uint32_t)) {
        std::memcpy(to + i, from + i, sizeof(uint32_t));
    }
    for (; i < count; ++i) to[i] = from[i];
}

// Of the length of its name, type and name, and value.
size_t parameter_bytes(const LogParameter& parameter) {
    return 1 + type_of(parameter).size() + parameter.name.size() + sizeof parameter.value;
}

// The graph's value, or the one that replaced it.
LogParameter value_at_start(const LogTable& table, uint32_t index) {
    const LogParameter& row = table.parameters[index];
    if (table.start == nullptr) return row;
    return {row.name, row.is_float, bits_of(table.start->rows[index])};
}

}  // namespace

void Logger::step(LoggerPorts& ports) {
    published_ = 0;
    // Read first: until the ports are passed on, the compiler knows the table, and leaves the code
    // for changes out where there are none.
    const LogChanges* const changes = ports.log->changes;
    const RecordingTable* const recording = ports.log->recording;
    blocks_at_once_ = recording == nullptr ? ports.log->blocks_at_once : recording->blocks_at_once;
    if (defined_ == 0) write_definition(ports, defined_++);  // the file's header
    write_tail(ports);
    if (recording != nullptr) write_streams(ports, *recording);
    if (write_definitions(ports)) {
        write_events(ports);
        write_samples(ports);
        if (changes != nullptr) write_changes(ports, *changes);
        if (recording != nullptr) write_recorded_definitions(ports, *recording);
    }
    if (recording != nullptr && tail_.empty() && has_room()) write_check(ports);
    if (ports.now - flushed_us_ >= kFlushInterval_us) flush(ports);
    previous_us_ = ports.now;
}

// True when all are written; samples come after them.
bool Logger::write_definitions(LoggerPorts& ports) {
    const LogTable& table = *ports.log;
    const uint32_t replaceable = table.start == nullptr ? 0 : table.parameter_count;
    const uint32_t count = 1 + 2 * table.topic_count + table.parameter_count + replaceable;
    while (defined_ < count && has_room_to_define()) write_definition(ports, defined_++);
    return defined_ == count && tail_.empty();
}

// Header, formats, parameters, subscriptions, and the graph's values of parameters that an option
// replaced, in this order.
void Logger::write_definition(LoggerPorts& ports, uint32_t index) {
    const LogTable& table = *ports.log;
    if (index == 0) return write_header(ports);
    index -= 1;
    if (index < table.topic_count) return write_format(ports, table.topics[index]);
    index -= table.topic_count;
    if (index < table.parameter_count) {
        return write_parameter(ports, value_at_start(table, index));
    }
    index -= table.parameter_count;
    if (index < table.topic_count) return write_subscription(ports, static_cast<uint16_t>(index));
    write_replaced(ports, index - table.topic_count);
}

void Logger::write_header(LoggerPorts& ports) {
    write(ports, kHeader.data(), kHeader.size());
    const std::array<std::byte, kFlagBytes> flags{};
    begin(ports, 'B', flags.size());
    write(ports, flags.data(), flags.size());
    write_info(ports, "sys_name", "Stator");
    write_info(ports, "ver_sw", ports.log->graph_hash);
    write_info(ports, "graph", ports.log->graph);
}

void Logger::write_subscription(LoggerPorts& ports, uint16_t id) {
    const std::string_view name = ports.log->topics[id].name;
    begin(ports, 'A', 1 + sizeof id + name.size());
    write(ports, "\0", 1);  // multi_id
    write(ports, &id, sizeof id);
    write_text(ports, name);
}

void Logger::write_info(LoggerPorts& ports, std::string_view key, std::string_view text) {
    // "char[N] key" with N in decimal.
    std::array<char, 8> size{};
    size_t digits = 0;
    for (size_t rest = text.size(); rest != 0 || digits == 0; rest /= 10) {
        size[digits++] = static_cast<char>('0' + rest % 10);
    }
    std::reverse(size.begin(), size.begin() + static_cast<ptrdiff_t>(digits));
    const size_t key_bytes = 5 + digits + 2 + key.size();
    begin(ports, 'I', 1 + key_bytes + text.size());
    const auto length = static_cast<uint8_t>(key_bytes);
    write(ports, &length, 1);
    write_text(ports, "char[");
    write(ports, size.data(), digits);
    write_text(ports, "] ");
    write_text(ports, key);
    write_text(ports, text);
}

// From the first subscription on, readers pass over messages of a type that they do not know.
bool Logger::has_subscribed(const LoggerPorts& ports) const {
    return defined_ > 1 + ports.log->topic_count + ports.log->parameter_count;
}

void Logger::write_format(LoggerPorts& ports, const LogTopic& row) {
    begin(ports, 'F', row.name.size() + 1 + row.format.size());
    write_text(ports, row.name);
    write_text(ports, ":"sv);
    tail_ = row.format;
    write_tail(ports);
}

void Logger::write_parameter(LoggerPorts& ports, const LogParameter& parameter) {
    begin(ports, 'P', parameter_bytes(parameter));
    write_value(ports, parameter);
}

// The default of this configuration, where the flight has another value.
void Logger::write_replaced(LoggerPorts& ports, uint32_t index) {
    const LogParameter& row = ports.log->parameters[index];
    if (value_at_start(*ports.log, index).value == row.value) return;
    begin(ports, 'Q', 1 + parameter_bytes(row));
    write(ports, &kConfigurationDefault, 1);
    write_value(ports, row);
}

void Logger::write_value(LoggerPorts& ports, const LogParameter& parameter) {
    const auto length = static_cast<uint8_t>(parameter_bytes(parameter) - 1 - 4);
    write(ports, &length, 1);
    write_text(ports, type_of(parameter));
    write_text(ports, parameter.name);
    write(ports, &parameter.value, sizeof parameter.value);
}

// Behind the samples: readers of a log take a change to be as old as the newest sample before it.
// Of one node in each activation.
void Logger::write_changes(LoggerPorts& ports, const LogChanges& changes) {
    for (uint32_t i = 0; i < changes.table->topic_count && has_room(); ++i) {
        const Topic& topic = *changes.table->topics[i].topic;
        Pin pin;
        if (!has_unread(topic, changes.seen[i])) continue;
        if (!take_latest(topic, changes.seen[i], pin)) continue;
        if (write_changes_of(ports, changes, i, sample_of(topic, pin))) {
            changes.seen[i] = number_of(topic, pin);
        }
        release(topic, pin);
        return;
    }
}

// False if some are left for lack of room: the next activation finds what it has written equal.
bool Logger::write_changes_of(LoggerPorts& ports, const LogChanges& changes, uint32_t topic,
                              const void* sample) {
    for (uint32_t i = 0; i < changes.table->row_count; ++i) {
        const ParameterRow& row = changes.table->rows[i];
        if (row.topic != topic) continue;
        const ParameterBits value = read_parameter(row, sample);
        // As its difference from the graph's value, so that it begins at 0.
        const ParameterBits change = value ^ row.standard;
        if (change == changes.logged[i]) continue;
        if (!has_room()) return false;
        changes.logged[i] = change;
        write_parameter(ports, {row.is.name, row.type == ParameterType::kFloat, value});
    }
    return true;
}

void Logger::write_samples(LoggerPorts& ports) {
    const LogTable& table = *ports.log;
    uint32_t lost = 0;
    for (uint16_t id = 0; id < table.topic_count; ++id) {
        const LogTopic& row = table.topics[id];
        Pin pin;
        while (has_room() && take_logged(row, ports.now, pin)) {
            write_sample(ports, row, id, sample_of(*row.topic, pin));
            release(*row.topic, pin);
        }
        lost += row.cursor->lost;
    }
    if (lost == lost_ || !has_room()) return;
    write_dropout(ports, ports.now - previous_us_);
    lost_ = lost;
}

void Logger::write_sample(LoggerPorts& ports, const LogTopic& row, uint16_t id,
                          const std::byte* sample) {
    const size_t bytes = row.bytes;
    begin(ports, 'D', sizeof id + bytes);
    write(ports, &id, sizeof id);
    uint8_t* copy = block_.data.data() + used_;  // `begin` made room for the whole sample
    write(ports, sample, bytes);
    canonicalise(reinterpret_cast<std::byte*>(copy), row.floats, row.float_count);
}

void Logger::write_events(LoggerPorts& ports) {
    constexpr char kWarning = '4';
    LogEvent event;
    while (has_room() && ports.log->events->next(events_read_, event)) {
        const std::string_view what = event.what;
        const std::string_view name = event.name;
        begin(ports, 'L', sizeof kWarning + sizeof event.time_us + what.size() + name.size());
        write(ports, &kWarning, sizeof kWarning);
        write(ports, &event.time_us, sizeof event.time_us);
        write_text(ports, what);
        write_text(ports, name);
    }
}

void Logger::write_dropout(LoggerPorts& ports, uint64_t duration_us) {
    const auto duration_ms = static_cast<uint16_t>(std::min<uint64_t>(duration_us / 1000, 65535));
    begin(ports, 'O', sizeof duration_ms);
    write(ports, &duration_ms, sizeof duration_ms);
}

void Logger::begin(LoggerPorts& ports, char type, size_t bytes) {
    const auto size = static_cast<uint16_t>(bytes);
    // A message starts in a block that holds it whole if any does, so that NaNs can be replaced in
    // place and a lost block costs whole messages only.
    if (used_ + 3 + bytes > kBlockBytes) flush(ports);
    const std::array<uint8_t, 3> head{static_cast<uint8_t>(size), static_cast<uint8_t>(size >> 8U),
                                      static_cast<uint8_t>(type)};
    write(ports, head.data(), head.size());
}

void Logger::write(LoggerPorts& ports, const void* bytes, size_t count) {
    const auto* from = static_cast<const uint8_t*>(bytes);
    while (count != 0) {
        if (used_ == kBlockBytes) flush(ports);
        const size_t fits = std::min(count, kBlockBytes - used_);
        copy(block_.data.data() + used_, from, fits);
        used_ += fits;
        from += fits;
        count -= fits;
    }
}

void Logger::write_text(LoggerPorts& ports, std::string_view text) {
    write(ports, text.data(), text.size());
}

// The end of a definition, as far as there is room.
void Logger::write_tail(LoggerPorts& ports) {
    while (!tail_.empty() && has_room_to_define()) {
        const size_t fits = std::min(tail_.size(), kBlockBytes - used_);
        write_text(ports, tail_.substr(0, fits));
        tail_.remove_prefix(fits);
        if (used_ == kBlockBytes) flush(ports);
    }
}

void Logger::flush(LoggerPorts& ports) {
    flushed_us_ = ports.now;
    if (used_ == 0) return;
    if (ports.log->recording != nullptr) check_block();
    checked_ = 0;
    ++published_;
    block_.length = static_cast<uint32_t>(used_);
    std::memset(block_.data.data() + used_, 0, kBlockBytes - used_);
    ports.block.publish([&] { return block_; });
    used_ = 0;
}

}  // namespace stator::apps::logger
