// Records in a memory that keeps its bytes without power, and that can be overwritten byte by byte:
// FRAM, or a file.
//
// Power may fail at any moment, also in the middle of a write. So each record has a slot, with a
// copy in either half of the memory; the copies are written one after the other, and each has a
// CRC. Whenever power fails, one copy at least is whole, the old record or the new one. Loading
// takes the newer one and writes the other one again. If one copy is damaged, nothing is lost; if
// both are, that record is, and no other. A write costs two slots: there is no garbage collection
// and no erasing. docs/decisions/0015-records-in-two-copies.md
//
// The memory is a port, chosen at compile time; each call takes a bounded time, and false says that
// the memory did not do it:
//
//     bool read(uint32_t address, std::span<uint8_t> bytes);
//     bool write(uint32_t address, std::span<const uint8_t> bytes);
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "messages/stored_record.hpp"
#include "stator/crc32.hpp"

namespace stator::drivers::nonvolatile {

// A slot as it lies in the memory; little-endian.
struct RecordSlot {
    static constexpr unsigned kBytes = 32;

    uint32_t sequence;  // greater than that of every record before; 100 a second last 497 days
    uint32_t key;
    uint16_t place;  // of the slot, so that one that was written elsewhere is not good
    uint8_t kind;
    uint8_t length;
    std::array<uint8_t, 16> data;
    uint32_t crc;  // of all before it

    uint32_t sum() const { return crc32_bitwise(this, kBytes - sizeof crc); }
    bool is_good(unsigned at) const { return place == at && length <= data.size() && crc == sum(); }
    bool has_record_of(const RecordSlot& other) const {
        return key == other.key && kind == other.kind && length == other.length &&
               data == other.data;
    }
};
static_assert(sizeof(RecordSlot) == RecordSlot::kBytes);
static_assert(std::endian::native == std::endian::little);

template <class Port>
class RecordStore {
  public:
    static constexpr unsigned kMaxRecords = 256;
    static constexpr uint32_t kBytes = 2 * kMaxRecords * RecordSlot::kBytes;

    enum class Load : uint8_t {
        kNothing,  // no record in this slot, or an outdated one
        kRecord,   // here it is
        kFailed    // the memory did not answer; try again
    };
    enum class Keep : uint8_t { kKept, kFull, kFailed };

    explicit RecordStore(Port port) : port_(port) {}

    bool is_loaded() const { return loaded_ == kMaxRecords; }
    // Reads the next slot, and mends it if need be. Call until `is_loaded`, and nothing else
    // before.
    Load load_next(StoredRecord& record);
    // Replaces the record of the same kind and key. One that it holds already is not written again.
    Keep keep(const StoredRecord& record);

    unsigned records() const { return records_; }
    unsigned mended() const { return mended_; }
    unsigned damaged() const { return damaged_; }

  private:
    struct Name {
        uint32_t key;
        uint8_t kind;
        bool is_used;
    };
    static constexpr uint32_t kHalf = kBytes / 2;

    static uint32_t address(unsigned copy, unsigned place) {
        return copy * kHalf + place * RecordSlot::kBytes;
    }
    bool read(unsigned copy, unsigned place, RecordSlot& slot) {
        std::array<uint8_t, RecordSlot::kBytes> bytes{};
        if (!port_.read(address(copy, place), bytes)) return false;
        slot = std::bit_cast<RecordSlot>(bytes);
        return true;
    }
    bool write(unsigned copy, unsigned place, const RecordSlot& slot) {
        const auto bytes = std::bit_cast<std::array<uint8_t, RecordSlot::kBytes>>(slot);
        return port_.write(address(copy, place), bytes);
    }
    // As it comes from the factory, or erased.
    static bool is_blank(const RecordSlot& slot) {
        const auto bytes = std::bit_cast<std::array<uint8_t, RecordSlot::kBytes>>(slot);
        const uint8_t first = bytes[0];
        return (first == 0 || first == 0xFF) &&
               std::all_of(bytes.begin(), bytes.end(), [=](uint8_t b) { return b == first; });
    }
    static bool is_newer(const RecordSlot& slot, const RecordSlot& other) {
        return slot.sequence > other.sequence;
    }
    // Its place; kMaxRecords: it is not there.
    unsigned find(uint32_t key, uint8_t kind) const {
        const auto is_it = [=](const Name& name) {
            return name.is_used && name.key == key && name.kind == kind;
        };
        const auto* const found = std::find_if(names_.begin(), names_.end(), is_it);
        return static_cast<unsigned>(found - names_.begin());
    }
    unsigned find_free() const {
        const auto* const found = std::find_if(names_.begin(), names_.end(),
                                               [](const Name& name) { return !name.is_used; });
        return static_cast<unsigned>(found - names_.begin());
    }
    void use(unsigned place, const RecordSlot& slot) {
        if (!names_[place].is_used) ++records_;
        names_[place] = {slot.key, slot.kind, true};
    }
    Load take(unsigned place, const RecordSlot& slot, StoredRecord& record);
    Load skip(const RecordSlot& second);

    Port port_;
    std::array<Name, kMaxRecords> names_{};  // of the records, by place
    unsigned loaded_ = 0;                    // slots
    unsigned records_ = 0;
    unsigned mended_ = 0;
    unsigned damaged_ = 0;
    uint32_t sequence_ = 0;  // the newest
};

// Neither copy is good. A second copy that was never written says that the first one was cut off:
// this record was never reported as kept.
template <class Port>
typename RecordStore<Port>::Load RecordStore<Port>::skip(const RecordSlot& second) {
    ++loaded_;
    if (!is_blank(second)) ++damaged_;
    return Load::kNothing;
}

// Two slots have records of one name if one was unreadable when the other was written. The newer
// one counts; the other slot is free.
template <class Port>
typename RecordStore<Port>::Load RecordStore<Port>::take(unsigned place, const RecordSlot& slot,
                                                         StoredRecord& record) {
    const unsigned other = find(slot.key, slot.kind);
    if (other < kMaxRecords) {
        RecordSlot there;
        if (!read(0, other, there)) return Load::kFailed;
        if (!is_newer(slot, there)) {
            ++loaded_;
            return Load::kNothing;
        }
        names_[other].is_used = false;
        --records_;
    }
    use(place, slot);
    ++loaded_;
    record = {.key = slot.key,
              .kind = static_cast<StoredRecord::Kind>(slot.kind),
              .length = slot.length,
              .data = slot.data};
    return Load::kRecord;
}

template <class Port>
typename RecordStore<Port>::Load RecordStore<Port>::load_next(StoredRecord& record) {
    const unsigned place = loaded_;
    std::array<RecordSlot, 2> copies;
    if (!read(0, place, copies[0]) || !read(1, place, copies[1])) return Load::kFailed;
    const bool first_is_good = copies[0].is_good(place);
    const bool second_is_good = copies[1].is_good(place);
    if (!first_is_good && !second_is_good) return skip(copies[1]);
    const bool is_second = !first_is_good || (second_is_good && is_newer(copies[1], copies[0]));
    const RecordSlot& newest = copies[is_second ? 1 : 0];
    if (!first_is_good || !second_is_good || copies[0].sequence != copies[1].sequence) {
        if (!write(is_second ? 0 : 1, place, newest)) return Load::kFailed;
        ++mended_;
    }
    sequence_ = std::max(sequence_, newest.sequence);
    return take(place, newest, record);
}

template <class Port>
typename RecordStore<Port>::Keep RecordStore<Port>::keep(const StoredRecord& record) {
    RecordSlot slot{.sequence = sequence_ + 1,
                    .key = record.key,
                    .place = 0,
                    .kind = static_cast<uint8_t>(record.kind),
                    .length = record.length,
                    .data = record.data,
                    .crc = 0};
    if (slot.length > slot.data.size()) slot.length = static_cast<uint8_t>(slot.data.size());
    std::fill(slot.data.begin() + slot.length, slot.data.end(), uint8_t{0});
    unsigned place = find(slot.key, slot.kind);
    if (place == kMaxRecords) place = find_free();
    if (place == kMaxRecords) return Keep::kFull;
    RecordSlot now;
    if (!read(0, place, now)) return Keep::kFailed;
    if (names_[place].is_used && now.is_good(place) && now.has_record_of(slot)) return Keep::kKept;
    slot.place = static_cast<uint16_t>(place);
    slot.crc = slot.sum();
    sequence_ = slot.sequence;
    if (!write(0, place, slot)) return Keep::kFailed;
    use(place, slot);
    return write(1, place, slot) ? Keep::kKept : Keep::kFailed;
}

}  // namespace stator::drivers::nonvolatile
