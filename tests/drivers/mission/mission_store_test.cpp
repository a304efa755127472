// Plans in a memory: what is committed counts, whenever power fails.
#include <gtest/gtest.h>

#include "memory.hpp"

namespace stator::drivers::mission {
namespace {

// True if it was taken.
bool upload(Store& store, unsigned list, unsigned count, int32_t first) {
    bool is_good = store.begin(list, count);
    for (unsigned i = 0; is_good && i < count; ++i) {
        is_good = store.add(list, i, item_of(first + static_cast<int32_t>(i)));
    }
    return is_good && store.commit(list, 0);
}

Store loaded(Memory& memory) {
    Store store(MemoryPort{&memory});
    for (int i = 0; i < 200 && !store.is_loaded(); ++i) store.load_some();
    EXPECT_TRUE(store.is_loaded());
    return store;
}

TEST(MissionStoreTest, an_empty_memory_has_empty_lists) {
    Memory memory;
    const Store store = loaded(memory);
    for (unsigned list = 0; list < Store::kLists; ++list) {
        EXPECT_EQ(store.list(list).count, 0U);
        EXPECT_EQ(store.list(list).id, 0U);
    }
}

TEST(MissionStoreTest, what_was_committed_is_there_after_a_start) {
    Memory memory;
    Store store = loaded(memory);
    ASSERT_TRUE(upload(store, 0, 1000, 1));
    ASSERT_TRUE(upload(store, 1, 4, 5000));
    ASSERT_TRUE(upload(store, 0, 20, 100));
    Store again = loaded(memory);
    EXPECT_EQ(again.list(0).count, 20U);
    EXPECT_EQ(again.list(1).count, 4U);
    EXPECT_EQ(again.list(2).count, 0U);
    EXPECT_EQ(again.list(0).id, store.list(0).id);
    EXPECT_NE(again.list(0).id, 0U);
    StoredItem item;
    ASSERT_TRUE(again.read(0, 19, item));
    EXPECT_EQ(item.x, 119);
    EXPECT_EQ(item.z, 5.0F);
}

TEST(MissionStoreTest, the_same_items_have_the_same_id) {
    Memory memory;
    Memory other;
    Store store = loaded(memory);
    Store second = loaded(other);
    ASSERT_TRUE(upload(store, 0, 20, 100));
    ASSERT_TRUE(upload(second, 0, 5, 1));
    ASSERT_TRUE(upload(second, 0, 20, 100));
    EXPECT_EQ(store.list(0).id, second.list(0).id);
}

// Old or new, whole, at each byte where power may fail.
TEST(MissionStoreTest, power_may_fail_at_any_byte_of_an_upload) {
    Memory before;
    {
        Store store = loaded(before);
        ASSERT_TRUE(upload(store, 0, 3, 1));
        ASSERT_TRUE(upload(store, 0, 5, 50));  // so that both areas have been used
    }
    const uint64_t start = before.written;
    Memory whole = before;
    {
        Store store = loaded(whole);
        ASSERT_TRUE(upload(store, 0, 4, 200));
    }
    for (uint64_t cut = start; cut <= whole.written; ++cut) {
        Memory memory = before;
        memory.cut_after = cut;
        {
            Store store = loaded(memory);
            EXPECT_EQ(upload(store, 0, 4, 200), cut == whole.written);
        }
        memory.cut_after = Memory::kNoCut;
        Store store = loaded(memory);
        const bool is_new = cut == whole.written;
        EXPECT_EQ(store.list(0).count, is_new ? 4U : 5U) << cut;
        StoredItem item;
        ASSERT_TRUE(store.read(0, 0, item));
        EXPECT_EQ(item.x, is_new ? 200 : 50) << cut;
    }
}

TEST(MissionStoreTest, a_damaged_list_gives_way_to_the_one_before) {
    Memory memory;
    {
        Store store = loaded(memory);
        ASSERT_TRUE(upload(store, 0, 3, 1));
        ASSERT_TRUE(upload(store, 0, 5, 50));
    }
    // The area of the newer list is the first one again: each list begins with the second.
    for (auto& [address, byte] : memory.bytes) {
        if (address >= 2 * Store::kLists * Store::kHeadBytes) {
            byte = static_cast<uint8_t>(byte ^ 1U);
            break;
        }
    }
    const Store store = loaded(memory);
    EXPECT_EQ(store.list(0).count, 3U);
}

TEST(MissionStoreTest, refuses_what_is_out_of_order_too_long_or_not_what_was_meant) {
    Memory memory;
    Store store = loaded(memory);
    EXPECT_FALSE(store.begin(0, Store::kMaxItems + 1));
    EXPECT_FALSE(store.begin(Store::kLists, 1));
    EXPECT_FALSE(store.add(0, 0, item_of(1))) << "nothing has begun";
    ASSERT_TRUE(store.begin(0, 2));
    EXPECT_FALSE(store.add(0, 1, item_of(1))) << "the second comes first";
    EXPECT_FALSE(store.add(1, 0, item_of(1))) << "another list";
    ASSERT_TRUE(store.add(0, 0, item_of(1)));
    EXPECT_FALSE(store.commit(0, 0)) << "one is missing";
    ASSERT_TRUE(store.begin(0, 1));
    ASSERT_TRUE(store.add(0, 0, item_of(1)));
    EXPECT_FALSE(store.add(0, 1, item_of(1))) << "one too many";
    EXPECT_FALSE(store.commit(0, 12345)) << "another content";
    EXPECT_EQ(store.list(0).count, 0U);
}

TEST(MissionStoreTest, nothing_is_taken_before_all_is_loaded) {
    Memory memory;
    Store store(MemoryPort{&memory});
    EXPECT_FALSE(store.begin(0, 1));
}

TEST(MissionStoreTest, ten_thousand_items_fit_and_load_in_bounded_parts) {
    Memory memory;
    Store store = loaded(memory);
    ASSERT_TRUE(upload(store, 0, Store::kMaxItems, 0));
    Store again(MemoryPort{&memory});
    unsigned parts = 0;
    for (; !again.is_loaded(); ++parts) again.load_some();
    EXPECT_EQ(parts, 40U) << "of 256 items each";
    EXPECT_EQ(again.list(0).count, Store::kMaxItems);
}

TEST(MissionStoreTest, a_memory_that_does_not_answer_counts_as_empty_after_some_tries) {
    Memory memory;
    {
        Store store = loaded(memory);
        ASSERT_TRUE(upload(store, 0, 3, 1));
    }
    memory.answers = false;
    Store store(MemoryPort{&memory});
    for (int i = 0; i < 4; ++i) store.load_some();
    EXPECT_FALSE(store.is_loaded());
    memory.answers = true;
    store.load_some();
    EXPECT_EQ(store.list(0).count, 3U);
}

}  // namespace
}  // namespace stator::drivers::mission
