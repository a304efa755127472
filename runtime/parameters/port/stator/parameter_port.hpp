// The port of the one node that changes and publishes the parameters of all others.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>

#include "stator/parameter_hash.hpp"
#include "stator/parameters.hpp"
#include "stator/tap.hpp"
#include "stator/topic.hpp"

namespace stator {

// What counts now is the newest sample of each topic, as nobody else publishes any. Context: the
// activation it belongs to.
class ParameterPort {
  public:
    ParameterPort() = default;
    ParameterPort(const ParameterPort&) = delete;
    ParameterPort& operator=(const ParameterPort&) = delete;

    std::span<const ParameterRow> rows() const {
        return table_ == nullptr ? std::span<const ParameterRow>()
                                 : std::span(table_->rows, table_->row_count);
    }

    std::span<const FormerParameter> former() const {
        return table_ == nullptr ? std::span<const FormerParameter>()
                                 : std::span(table_->former, table_->former_count);
    }

    // The value that counts now, of one of the rows. Like `publish` it is not inlined: both are
    // long, rare, and called in several places.
    [[gnu::noinline]] ParameterBits value(const ParameterRow& row) const {
        const Topic& topic = *table_->topics[row.topic].topic;
        Pin pin;
        if (!take_latest(topic, 0, pin)) return row.standard;
        const ParameterBits value = read_parameter(row, sample_of(topic, pin));
        release(topic, pin);
        return value;
    }

    // Publishes the parameters of the row's node with this one changed, as one sample. Its node
    // sees it at its next activation; nobody is woken.
    [[gnu::noinline]] void publish(const ParameterRow& row, ParameterBits value) {
        const ParameterTopic& target = table_->topics[row.topic];
        const Topic& topic = *target.topic;
        Pin pin;
        if (!take_latest(topic, 0, pin)) return;  // never: all are published at the start
        const Loan loaned = loan(topic, target.keep);
        std::byte* const message = slot_at(topic, loaned.slot);
        std::memcpy(message, sample_of(topic, pin), topic.sample_bytes);
        release(topic, pin);
        write_parameter(row, message, value);
        std::memcpy(message, &now_us_, sizeof now_us_);  // `timestamp` is every message's first
        Tap tap = taps_.at(row.topic);
        tap.builds(message);
        const uint32_t hash = tap.commits(message, topic.sample_bytes);
        tap.committed(hash, commit(topic, loaned, message));
    }

    // --- for generated wrappers ---
    void connect(const ParameterTable& table, uint64_t now_us) {
        table_ = &table;
        now_us_ = now_us;
    }
    // Where the build records: connects the taps.
    template <class... Parts>
    void record(Parts&&... parts) {
        taps_.connect(parts...);
    }

  private:
    const ParameterTable* table_ = nullptr;
    uint64_t now_us_ = 0;
    [[no_unique_address]] Taps taps_;
};

}  // namespace stator
