// Records in two copies: power that fails after each single byte, and bytes that change by
// themselves.
#include <gtest/gtest.h>

#include <map>

#include "memory.hpp"

namespace stator::drivers::nonvolatile {
namespace {

using Contents = std::map<uint32_t, uint8_t>;  // key -> the value of all bytes of its record

// What a start finds.
struct Started {
    explicit Started(Memory& memory) : store(MemoryPort{&memory}) {
        StoredRecord record{};
        while (!store.is_loaded()) {
            const auto result = store.load_next(record);
            if (result == Store::Load::kFailed) return;  // power failed
            if (result == Store::Load::kRecord) note(record);
        }
    }
    void note(const StoredRecord& record) {
        EXPECT_EQ(record.length, 9);
        for (unsigned i = 0; i < record.data.size(); ++i) {
            EXPECT_EQ(record.data[i], i < record.length ? record.data[0] : 0) << "a mixture";
        }
        EXPECT_EQ(contents.count(record.key), 0U) << "once only";
        contents[record.key] = record.data[0];
    }

    Store store;
    Contents contents;
};

struct Step {
    uint32_t key;
    uint8_t value;
};
// New ones, changed ones, and one that stays as it is.
constexpr Step kSteps[]{{1, 10}, {2, 20}, {1, 11}, {3, 30}, {2, 20}, {2, 21}, {1, 12}, {3, 31}};

// Keeps until power fails, on top of what is there. What is sure to be kept then, and what may be.
struct Kept {
    Contents sure;
    Contents possible;
};
Kept keep_all(Memory& memory, uint8_t more = 0) {
    Started started(memory);
    Kept kept{.sure = started.contents, .possible = started.contents};
    for (const Step& step : kSteps) {
        const auto value = static_cast<uint8_t>(step.value + more);
        kept.possible[step.key] = value;
        const auto result = started.store.keep(record_of(step.key, value));
        if (result != Store::Keep::kKept) return kept;
        kept.sure = kept.possible;
    }
    return kept;
}

uint64_t bytes_of_all() {
    Memory memory;
    keep_all(memory);
    return memory.written;
}

struct Cut : ::testing::TestWithParam<bool> {
    static Memory cut_memory(uint8_t blank, uint64_t cut) {
        Memory memory(blank);
        memory.cut_after = cut;
        memory.spoils_last = GetParam();
        return memory;
    }
    static void restore_power(Memory& memory) {
        memory.written = 0;
        memory.cut_after = Memory::kNoCut;
    }
};

TEST_P(Cut, after_each_byte_the_old_record_or_the_new_one_is_there) {
    const uint64_t most = bytes_of_all();
    EXPECT_EQ(most, 7 * 2 * 32U) << "seven changes, two copies of 32 bytes";
    for (const uint8_t blank : {uint8_t{0x00}, uint8_t{0xFF}}) {
        for (uint64_t cut = 0; cut <= most; ++cut) {
            Memory memory = cut_memory(blank, cut);
            const Kept kept = keep_all(memory);
            restore_power(memory);
            Started started(memory);
            ASSERT_TRUE(started.store.is_loaded());
            EXPECT_TRUE(started.contents == kept.sure || started.contents == kept.possible) << cut;
            EXPECT_EQ(started.store.damaged(), 0U) << cut;
            EXPECT_LE(started.store.mended(), 1U) << cut;
            Started again(memory);
            EXPECT_EQ(again.contents, started.contents) << cut;
            EXPECT_EQ(again.store.mended(), 0U) << cut;
        }
    }
}

TEST_P(Cut, after_each_byte_of_a_later_start_too) {
    for (uint64_t cut = 0; cut <= bytes_of_all(); ++cut) {
        Memory memory;
        keep_all(memory);
        memory.written = 0;
        memory.cut_after = cut;
        memory.spoils_last = GetParam();
        const Kept kept = keep_all(memory, 100);
        restore_power(memory);
        Started started(memory);
        EXPECT_TRUE(started.contents == kept.sure || started.contents == kept.possible) << cut;
        EXPECT_EQ(started.store.damaged(), 0U) << cut;
    }
}

TEST_P(Cut, after_each_byte_of_the_mending_too) {
    for (uint64_t cut = 0; cut <= bytes_of_all(); ++cut) {
        Memory once = cut_memory(0, cut);
        const Kept kept = keep_all(once);
        restore_power(once);
        Memory mended = once;
        const Contents contents = Started(mended).contents;
        for (uint64_t second = 0; second < mended.written; ++second) {
            Memory twice = once;
            twice.cut_after = second;
            Started interrupted(twice);
            EXPECT_FALSE(interrupted.store.is_loaded());
            restore_power(twice);
            Started started(twice);
            EXPECT_EQ(started.contents, contents) << cut << " and " << second;
            EXPECT_EQ(started.store.damaged(), 0U);
        }
    }
}

TEST_P(Cut, and_then_goes_on_where_it_was) {
    for (uint64_t cut = 0; cut <= bytes_of_all(); ++cut) {
        Memory memory = cut_memory(0, cut);
        keep_all(memory);
        restore_power(memory);
        const Kept kept = keep_all(memory);
        EXPECT_EQ(Started(memory).contents, kept.sure) << cut;
        EXPECT_EQ(Started(memory).store.records(), 3U) << "no slot is used twice";
    }
}

INSTANTIATE_TEST_SUITE_P(record_store, Cut, ::testing::Bool(), [](const auto& spoils) {
    return spoils.param ? "spoils_the_last_byte" : "between_bytes";
});

TEST(RecordStore, one_changed_bit_costs_nothing) {
    Memory good;
    const Contents contents = keep_all(good).sure;
    for (unsigned copy = 0; copy < 2; ++copy) {
        for (unsigned bit = 0; bit < 3 * 32 * 8; ++bit) {
            Memory memory = good;
            memory.bytes[copy * 8192 + bit / 8] ^= static_cast<uint8_t>(1U << bit % 8);
            Started started(memory);
            EXPECT_EQ(started.contents, contents) << copy << ", " << bit;
            EXPECT_EQ(started.store.mended(), 1U);
            EXPECT_EQ(started.store.damaged(), 0U);
            EXPECT_EQ(memory.bytes, good.bytes) << "mended";
        }
    }
}

TEST(RecordStore, both_copies_damaged_is_told_and_the_others_are_kept) {
    Memory memory;
    Contents contents = keep_all(memory).sure;
    memory.bytes[32 + 20] ^= 1;
    memory.bytes[8192 + 32 + 21] ^= 1;
    contents.erase(2);
    Started started(memory);
    EXPECT_EQ(started.contents, contents);
    EXPECT_EQ(started.store.damaged(), 1U);
    ASSERT_EQ(started.store.keep(record_of(2, 22)), Store::Keep::kKept);
    contents[2] = 22;
    Started again(memory);
    EXPECT_EQ(again.contents, contents);
    EXPECT_EQ(again.store.damaged(), 0U) << "its place is used again";
}

TEST(RecordStore, a_memory_full_of_something_else_is_told_and_can_be_used) {
    Memory memory;
    for (unsigned i = 0; i < memory.bytes.size(); ++i) {
        memory.bytes[i] = static_cast<uint8_t>(1 + i * 7 % 255);
    }
    Started started(memory);
    EXPECT_TRUE(started.contents.empty());
    EXPECT_EQ(started.store.damaged(), 255U);
    const Contents sure = keep_all(memory).sure;
    EXPECT_EQ(Started(memory).contents, sure);
}

TEST(RecordStore, a_slot_of_another_place_does_not_count) {
    Memory memory;
    keep_all(memory);
    for (const unsigned half : {0U, 8192U}) {
        std::copy_n(memory.bytes.begin() + half, 32, memory.bytes.begin() + half + 10 * 32);
    }
    Started started(memory);
    EXPECT_EQ(started.contents.size(), 3U);
    EXPECT_EQ(started.store.damaged(), 1U);
}

void put_copy(Memory& memory, unsigned copy, uint16_t place, uint32_t sequence,
              const StoredRecord& record) {
    RecordSlot slot{.sequence = sequence,
                    .key = record.key,
                    .place = place,
                    .kind = static_cast<uint8_t>(record.kind),
                    .length = record.length,
                    .data = record.data,
                    .crc = 0};
    slot.crc = slot.sum();
    memory.put(copy * 8192 + place * 32U,
               std::bit_cast<std::array<uint8_t, RecordSlot::kBytes>>(slot));
}
void put(Memory& memory, uint16_t place, uint32_t sequence, const StoredRecord& record) {
    put_copy(memory, 0, place, sequence, record);
    put_copy(memory, 1, place, sequence, record);
}

// A disk may have done the second write alone.
TEST(RecordStore, of_two_good_copies_the_newer_counts_whichever_it_is) {
    for (const uint32_t second_sequence : {4U, 6U}) {
        Memory memory;
        put_copy(memory, 0, 0, 5, record_of(1, 50));
        put_copy(memory, 1, 0, second_sequence, record_of(1, 60));
        const Contents contents{{1, second_sequence == 6 ? 60 : 50}};
        EXPECT_EQ(Started(memory).contents, contents);
        EXPECT_EQ(Started(memory).store.mended(), 0U) << "it was at the start before";
    }
}

// As after a start at which the one slot could not be read. Readers take what comes last.
TEST(RecordStore, of_two_slots_with_one_record_the_newer_counts) {
    for (const uint32_t second_sequence : {4U, 6U}) {
        Memory memory;
        put(memory, 0, 5, record_of(1, 50));
        put(memory, 1, second_sequence, record_of(1, 60));
        const uint8_t newest = second_sequence == 6 ? 60 : 50;
        Store store(MemoryPort{&memory});
        StoredRecord record{};
        uint8_t last = 0;
        while (!store.is_loaded()) {
            if (store.load_next(record) == Store::Load::kRecord) last = record.data[0];
        }
        EXPECT_EQ(last, newest);
        EXPECT_EQ(store.records(), 1U);
        ASSERT_EQ(store.keep(record_of(2, 20)), Store::Keep::kKept);
        const Contents contents{{1, newest}, {2, 20}};
        EXPECT_EQ(Started(memory).contents, contents) << "the other slot was free";
    }
}

TEST(RecordStore, what_is_kept_after_a_start_is_newer_than_what_was_there) {
    Memory memory;
    put(memory, 0, 100, record_of(1, 50));
    ASSERT_EQ(Started(memory).store.keep(record_of(1, 51)), Store::Keep::kKept);
    put(memory, 1, 100, record_of(1, 50));  // which could not be read at that start
    const Contents contents{{1, 51}};
    EXPECT_EQ(Started(memory).contents, contents);
}

TEST(RecordStore, a_full_one_refuses_new_records_and_takes_changes) {
    Memory memory;
    {
        Started started(memory);
        for (uint32_t key = 0; key < Store::kMaxRecords; ++key) {
            ASSERT_EQ(started.store.keep(record_of(key, 1)), Store::Keep::kKept);
        }
        EXPECT_EQ(started.store.keep(record_of(1000, 1)), Store::Keep::kFull);
        EXPECT_EQ(started.store.keep(record_of(100, 2)), Store::Keep::kKept);
    }
    Started started(memory);
    EXPECT_EQ(started.contents.size(), 255U);
    EXPECT_EQ(started.contents[100], 2);
    EXPECT_EQ(started.contents.count(1000), 0U);
}

TEST(RecordStore, what_is_there_already_is_not_written_again) {
    Memory memory;
    keep_all(memory);
    Started started(memory);
    memory.written = 0;
    EXPECT_EQ(started.store.keep(record_of(3, 31)), Store::Keep::kKept);
    EXPECT_EQ(memory.written, 0U);
}

TEST(RecordStore, what_has_gone_bad_since_the_start_is_written_again) {
    Memory memory;
    keep_all(memory);
    Started started(memory);
    memory.bytes[2 * 32 + 29] ^= 1;  // in the checksum of the third record
    EXPECT_EQ(started.store.keep(record_of(3, 31)), Store::Keep::kKept);
    EXPECT_EQ(Started(memory).store.mended(), 0U);
}

StoredRecord removed(uint32_t key) {
    return {.key = key, .kind = StoredRecord::Kind::kParameter};
}

TEST(RecordStore, a_removed_record_does_not_come_back_and_its_slot_is_free) {
    Memory memory;
    Contents contents = keep_all(memory).sure;
    {
        Started started(memory);
        ASSERT_EQ(started.store.keep(removed(1)), Store::Keep::kKept);
        EXPECT_EQ(started.store.records(), 2U);
    }
    contents.erase(1);
    Started started(memory);
    EXPECT_EQ(started.contents, contents);
    EXPECT_EQ(started.store.records(), 2U);
    for (uint32_t key = 1000; key < 1000 + Store::kMaxRecords - 2; ++key) {
        ASSERT_EQ(started.store.keep(record_of(key, 1)), Store::Keep::kKept);
    }
    EXPECT_EQ(started.store.keep(record_of(1, 1)), Store::Keep::kFull);
}

TEST(RecordStore, what_is_not_there_is_removed_without_a_write) {
    Memory memory;
    Started started(memory);
    EXPECT_EQ(started.store.keep(removed(1)), Store::Keep::kKept);
    EXPECT_EQ(memory.written, 0U);
}

// The older one of two slots with one record must not outlive the newer one.
TEST(RecordStore, a_record_that_is_removed_takes_its_older_slots_along) {
    for (const bool is_first : {false, true}) {
        Memory memory;
        put(memory, is_first ? 0 : 1, 5, record_of(1, 50));
        put(memory, is_first ? 1 : 0, 6, record_of(1, 60));
        StoredRecord record{};
        {
            Store store(MemoryPort{&memory});
            while (!store.is_loaded()) static_cast<void>(store.load_next(record));
            ASSERT_EQ(store.keep(removed(1)), Store::Keep::kKept);
            ASSERT_EQ(store.keep(record_of(2, 20)), Store::Keep::kKept);
        }
        const Contents contents{{2, 20}};
        EXPECT_EQ(Started(memory).contents, contents);
    }
}

// As after a start at which the older slot could not be read. Readers take what comes last.
TEST(RecordStore, a_removal_is_told_if_the_removed_record_was) {
    Memory memory;
    put(memory, 0, 5, record_of(1, 50));
    put(memory, 1, 6, removed(1));
    Store store(MemoryPort{&memory});
    StoredRecord record{};
    unsigned last_length = 99;
    while (!store.is_loaded()) {
        if (store.load_next(record) == Store::Load::kRecord) last_length = record.length;
    }
    EXPECT_EQ(last_length, 0U);
    EXPECT_TRUE(Started(memory).contents.empty());
}

TEST_P(Cut, a_removal_is_done_or_not) {
    for (uint64_t cut = 0; cut <= 64; ++cut) {
        Memory memory;
        const Contents before = keep_all(memory).sure;
        {
            Started started(memory);
            memory.written = 0;
            memory.cut_after = cut;
            memory.spoils_last = GetParam();
            static_cast<void>(started.store.keep(removed(1)));
        }
        restore_power(memory);
        Contents after = before;
        after.erase(1);
        Started started(memory);
        EXPECT_TRUE(started.contents == before || started.contents == after) << cut;
        EXPECT_EQ(started.store.damaged(), 0U) << cut;
    }
}

// Random changes, removals, power cuts and starts: of each record the old value or the new one.
TEST(RecordStore, in_random_histories_nothing_but_the_newest_change_is_in_doubt) {
    for (uint64_t seed = 1; seed <= 500; ++seed) {
        uint64_t state = seed * 0x9E3779B97F4A7C15U;
        const auto random = [&state](uint64_t below) {  // xorshift64
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            return state % below;
        };
        Memory memory(random(2) == 0 ? 0x00 : 0xFF);
        Contents sure;
        for (int life = 0; life < 8; ++life) {
            memory.written = 0;
            memory.cut_after = random(3) == 0 ? Memory::kNoCut : random(1500);
            memory.spoils_last = random(2) == 0;
            Started started(memory);
            if (started.store.is_loaded()) {
                ASSERT_EQ(started.contents, sure) << seed << ", life " << life;
            }
            Contents possible = sure;
            for (int i = 0; i < 20 && started.store.is_loaded(); ++i) {
                const auto key = static_cast<uint32_t>(1 + random(12));
                const auto value = static_cast<uint8_t>(random(250));
                const bool is_removal = random(4) == 0;
                possible = sure;
                if (is_removal) {
                    possible.erase(key);
                } else {
                    possible[key] = value;
                }
                const auto kept =
                    started.store.keep(is_removal ? removed(key) : record_of(key, value));
                if (kept != Store::Keep::kKept) break;
                sure = possible;
            }
            memory.written = 0;
            memory.cut_after = Memory::kNoCut;
            Started found(memory);
            ASSERT_TRUE(found.contents == sure || found.contents == possible)
                << seed << ", life " << life;
            ASSERT_EQ(found.store.damaged(), 0U) << seed;
            sure = found.contents;
        }
    }
}

// --- a memory that does not do what it says ---

// While its supply settles, a memory reads as if nothing had ever been written.
TEST(RecordStore, what_was_read_as_blank_is_not_written_over) {
    Memory memory;
    const Contents contents = keep_all(memory).sure;
    const std::vector<uint8_t> good = memory.bytes;
    std::fill(memory.bytes.begin(), memory.bytes.end(), uint8_t{0xFF});
    Started started(memory);
    ASSERT_TRUE(started.contents.empty());
    memory.bytes = good;
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(started.store.keep(record_of(9, 90)), Store::Keep::kFailed);
        EXPECT_EQ(memory.bytes, good);
    }
    EXPECT_EQ(started.store.keep(record_of(9, 90)), Store::Keep::kKept) << "behind those three";
    Contents both = contents;
    both[9] = 90;
    EXPECT_EQ(Started(memory).contents, both);
}

struct Glitch {
    bool read(uint32_t address, std::span<uint8_t> data) {
        std::copy_n(memory->bytes.begin() + address, data.size(), data.begin());
        if ((*reads)++ == bad_read) data[7] ^= 0x10;
        return true;
    }
    bool write(uint32_t address, std::span<const uint8_t> data) {
        return memory->put(address, data);
    }
    Memory* memory;
    uint64_t* reads;
    uint64_t bad_read;
};

TEST(RecordStore, one_wrong_read_changes_nothing) {
    Memory good;
    const Contents contents = keep_all(good).sure;
    for (uint64_t bad_read = 0; bad_read < 40; ++bad_read) {
        Memory memory = good;
        memory.written = 0;
        uint64_t reads = 0;
        RecordStore<Glitch> store(Glitch{&memory, &reads, bad_read});
        Contents found;
        StoredRecord record{};
        for (int tries = 0; !store.is_loaded() && tries < 300; ++tries) {
            if (store.load_next(record) == RecordStore<Glitch>::Load::kRecord) {
                found[record.key] = record.data[0];
            }
        }
        EXPECT_EQ(found, contents) << bad_read;
        EXPECT_EQ(memory.written, 0U) << bad_read;
    }
}

struct Forgetful {
    bool read(uint32_t, std::span<uint8_t> data) {
        std::fill(data.begin(), data.end(), uint8_t{0});
        return true;
    }
    bool write(uint32_t, std::span<const uint8_t>) { return true; }
};

TEST(RecordStore, a_memory_that_takes_writes_and_keeps_nothing_is_noticed) {
    RecordStore<Forgetful> store(Forgetful{});
    StoredRecord record{};
    while (!store.is_loaded()) static_cast<void>(store.load_next(record));
    EXPECT_EQ(store.keep(record_of(1, 1)), RecordStore<Forgetful>::Keep::kFailed);
}

// --- starts ---

unsigned short_lives_of(Store& store) {
    unsigned lives = 99;
    EXPECT_TRUE(store.count_start(lives));
    return lives;
}

TEST(RecordStore, starts_that_do_not_live_long_are_counted) {
    Memory memory;
    for (unsigned i = 0; i < 3; ++i) {
        Store store(MemoryPort{&memory});
        EXPECT_EQ(short_lives_of(store), i);
    }
    Store store(MemoryPort{&memory});
    EXPECT_EQ(short_lives_of(store), 3U);
    EXPECT_TRUE(store.forget_starts());
    Store next(MemoryPort{&memory});
    EXPECT_EQ(short_lives_of(next), 0U);
}

TEST_P(Cut, the_count_of_starts_is_the_old_one_or_the_new_one) {
    for (uint64_t cut = 0; cut <= 64; ++cut) {
        Memory memory;
        keep_all(memory);
        for (unsigned i = 0; i < 2; ++i) {
            Store store(MemoryPort{&memory});
            short_lives_of(store);
        }
        memory.written = 0;
        memory.cut_after = cut;
        memory.spoils_last = GetParam();
        unsigned lives = 0;
        Store store(MemoryPort{&memory});
        static_cast<void>(store.count_start(lives));
        restore_power(memory);
        Store next(MemoryPort{&memory});
        const unsigned found = short_lives_of(next);
        EXPECT_TRUE(found == 2 || found == 3) << cut << ": " << found;
        EXPECT_EQ(Started(memory).contents.size(), 3U) << "records are not touched";
    }
}

TEST(RecordStore, kinds_have_keys_of_their_own) {
    Memory memory;
    {
        Started started(memory);
        StoredRecord record = record_of(1, 5);
        ASSERT_EQ(started.store.keep(record), Store::Keep::kKept);
        record.kind = StoredRecord::Kind::kCanNode;
        ASSERT_EQ(started.store.keep(record), Store::Keep::kKept);
    }
    Store store(MemoryPort{&memory});
    StoredRecord record{};
    while (!store.is_loaded()) static_cast<void>(store.load_next(record));
    EXPECT_EQ(store.records(), 2U);
}

}  // namespace
}  // namespace stator::drivers::nonvolatile
