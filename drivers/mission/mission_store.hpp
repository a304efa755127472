// Three lists of mission items in a memory that keeps its bytes: a file, or a card's.
//
// Each list has two areas and a head for each. A new list is written into the area that is not in
// use, item by item; then one write of its head, with a greater generation and the CRC of all
// items, makes it the list that counts. Whenever power fails, the list is the old one or the new
// one, whole. The memory is a port, chosen at compile time; each call takes a bounded time, and
// false says that the memory did not do it:
//
//     bool read(uint32_t address, std::span<uint8_t> bytes);
//     bool write(uint32_t address, std::span<const uint8_t> bytes);
//
// Nothing of a list stands in RAM, whatever its length. codegen/stator/mission/store.py writes the
// same layout.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "stator/crc32.hpp"

namespace stator::drivers::mission {

// An item as it lies in the memory; little-endian. Fields of MAVLink's MISSION_ITEM_INT.
struct StoredItem {
    uint16_t command = 0;
    uint8_t frame = 0;
    uint8_t autocontinue = 0;
    float param1 = 0.0F;
    float param2 = 0.0F;
    float param3 = 0.0F;
    float param4 = 0.0F;
    int32_t x = 0;
    int32_t y = 0;
    float z = 0.0F;
};
static_assert(sizeof(StoredItem) == 32);

// The head of an area.
struct StoredHead {
    uint32_t magic = 0;
    uint32_t generation = 0;  // greater than that of the list before
    uint32_t count = 0;
    uint32_t id = 0;   // CRC-32 of all items
    uint32_t crc = 0;  // of all before it
};
static_assert(sizeof(StoredHead) == 20);
static_assert(std::endian::native == std::endian::little);

template <class Port>
class MissionStore {
  public:
    static constexpr unsigned kLists = 3;  // mission, fence, rally points
    static constexpr unsigned kMaxItems = 10000;
    static constexpr unsigned kMaxFenceItems = 128;
    static constexpr unsigned kMaxRallyPoints = 16;
    static constexpr uint32_t kMagic = 0x314D5453;  // "STM1"
    static constexpr uint32_t kHeadBytes = 32;      // the space that a head takes
    static constexpr uint32_t kItemBytes = sizeof(StoredItem);
    static constexpr uint32_t kBytes =
        2 * (kLists * kHeadBytes + kItemBytes * (kMaxItems + kMaxFenceItems + kMaxRallyPoints));

    struct List {
        uint32_t id = 0;
        uint32_t count = 0;
        uint32_t generation = 0;
        unsigned area = 0;
    };

    explicit MissionStore(Port port) : port_(port) {}

    static constexpr unsigned most(unsigned list) {
        constexpr std::array<unsigned, kLists> kMost{kMaxItems, kMaxFenceItems, kMaxRallyPoints};
        return kMost[list];
    }
    const List& list(unsigned number) const { return lists_[number]; }

    bool is_loaded() const { return loading_ == kLists; }
    // Reads on, by a bounded number of bytes; of each list, the newest area that is whole counts.
    // Call until `is_loaded`, and nothing else before.
    void load_some();
    [[nodiscard]] bool read(unsigned list, unsigned index, StoredItem& item) {
        return read_item(list, lists_[list].area, index, item);
    }

    // A new list. Each says whether it was done; what is refused leaves the list as it is.
    [[nodiscard]] bool begin(unsigned list, unsigned count);
    [[nodiscard]] bool add(unsigned list, unsigned index, const StoredItem& item);
    [[nodiscard]] bool commit(unsigned list, uint32_t id);

  private:
    static constexpr unsigned kItemsAtOnce = 256;
    static constexpr unsigned kMaxFailures = 5;
    static constexpr unsigned kNone = kLists;  // of uploads

    static uint32_t head_address(unsigned list, unsigned area) {
        return (2 * list + area) * kHeadBytes;
    }
    static uint32_t item_address(unsigned list, unsigned area, unsigned index) {
        uint32_t address = 2 * kLists * kHeadBytes;
        for (unsigned i = 0; i < list; ++i) address += 2 * most(i) * kItemBytes;
        return address + (area * most(list) + index) * kItemBytes;
    }
    bool read_item(unsigned list, unsigned area, unsigned index, StoredItem& item) {
        std::array<uint8_t, kItemBytes> bytes{};
        if (!port_.read(item_address(list, area, index), bytes)) return false;
        item = std::bit_cast<StoredItem>(bytes);
        return true;
    }
    bool read_head(unsigned list, unsigned area, StoredHead& head) {
        std::array<uint8_t, sizeof(StoredHead)> bytes{};
        if (!port_.read(head_address(list, area), bytes)) return false;
        head = std::bit_cast<StoredHead>(bytes);
        return true;
    }
    static bool is_good(unsigned list, const StoredHead& head) {
        return head.magic == kMagic && head.count <= most(list) && head.crc == sum(head);
    }
    static uint32_t sum(const StoredHead& head) {
        return crc32(0, &head, sizeof head - sizeof head.crc);
    }
    enum class Load : uint8_t { kDone, kFailed };

    Load choose_area();
    Load check_area(unsigned& items_left);
    void next_list() {
        ++loading_;
        tries_ = 0;
        has_area_ = false;
    }

    Port port_;
    std::array<List, kLists> lists_{};
    // While loading.
    unsigned loading_ = 0;  // list
    unsigned tries_ = 0;    // areas of it
    unsigned failures_ = 0;
    bool has_area_ = false;
    List tried_;
    unsigned checked_ = 0;  // items of it
    uint32_t crc_ = 0;
    // Of an upload.
    unsigned uploading_ = kNone;
    unsigned added_ = 0;
    unsigned expected_ = 0;
};

// The next area of the list to try: first the newer one.
template <class Port>
typename MissionStore<Port>::Load MissionStore<Port>::choose_area() {
    std::array<StoredHead, 2> heads{};
    for (unsigned area = 0; area < 2; ++area) {
        if (!read_head(loading_, area, heads[area])) return Load::kFailed;
    }
    const bool second_is_good = is_good(loading_, heads[1]);
    const bool second_is_newer = second_is_good && (!is_good(loading_, heads[0]) ||
                                                    heads[1].generation > heads[0].generation);
    const unsigned area = second_is_newer == (tries_ == 0) ? 1 : 0;
    const StoredHead& head = heads[area];
    if (tries_ == 2 || !is_good(loading_, head)) {
        next_list();
        return Load::kDone;
    }
    tried_ = {head.id, head.count, head.generation, area};
    has_area_ = true;
    checked_ = 0;
    crc_ = 0;
    ++tries_;
    return Load::kDone;
}

template <class Port>
typename MissionStore<Port>::Load MissionStore<Port>::check_area(unsigned& items_left) {
    for (; checked_ < tried_.count && items_left != 0; ++checked_, --items_left) {
        StoredItem item{};
        if (!read_item(loading_, tried_.area, checked_, item)) return Load::kFailed;
        crc_ = crc32(crc_, &item, sizeof item);
    }
    if (checked_ < tried_.count) return Load::kDone;
    has_area_ = false;
    if (crc_ == tried_.id) {
        lists_[loading_] = tried_;
        next_list();
    }
    return Load::kDone;
}

// A memory that does not answer is asked again in the next activations, and then counts as empty.
template <class Port>
void MissionStore<Port>::load_some() {
    for (unsigned items_left = kItemsAtOnce; !is_loaded() && items_left != 0;) {
        const Load result = has_area_ ? check_area(items_left) : choose_area();
        if (result == Load::kDone) continue;
        if (++failures_ < kMaxFailures) return;
        loading_ = kLists;
    }
}

template <class Port>
bool MissionStore<Port>::begin(unsigned list, unsigned count) {
    uploading_ = kNone;
    if (!is_loaded() || list >= kLists || count > most(list)) return false;
    uploading_ = list;
    expected_ = count;
    added_ = 0;
    crc_ = 0;
    return true;
}

template <class Port>
bool MissionStore<Port>::add(unsigned list, unsigned index, const StoredItem& item) {
    if (list != uploading_ || index != added_ || added_ == expected_) return false;
    const auto bytes = std::bit_cast<std::array<uint8_t, kItemBytes>>(item);
    if (!port_.write(item_address(list, 1 - lists_[list].area, index), bytes)) return false;
    crc_ = crc32(crc_, &item, sizeof item);
    ++added_;
    return true;
}

template <class Port>
bool MissionStore<Port>::commit(unsigned list, uint32_t id) {
    const bool is_whole = list == uploading_ && added_ == expected_ && (id == 0 || id == crc_);
    uploading_ = kNone;
    if (!is_whole) return false;
    StoredHead head{.magic = kMagic,
                    .generation = lists_[list].generation + 1,
                    .count = added_,
                    .id = crc_,
                    .crc = 0};
    head.crc = sum(head);
    const unsigned area = 1 - lists_[list].area;
    const auto bytes = std::bit_cast<std::array<uint8_t, sizeof(StoredHead)>>(head);
    if (!port_.write(head_address(list, area), bytes)) return false;
    lists_[list] = {head.id, head.count, head.generation, area};
    return true;
}

}  // namespace stator::drivers::mission
