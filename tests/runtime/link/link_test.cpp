// Frames and the link: every body comes through, damage does not, and the next frame always does.
#include "stator/link.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <deque>
#include <random>
#include <vector>

#include "stator/answers.hpp"

namespace {

using namespace stator;
using Bytes = std::vector<uint8_t>;

Bytes framed(Bytes body) {
    const size_t count = body.size();
    body.resize(count + kCrcBytes);
    Bytes frame(frame_bytes(count));
    frame.resize(write_frame(body.data(), count, frame.data()));
    return frame;
}

template <class Reader>
std::vector<Bytes> bodies_in(Reader& reader, const Bytes& stream) {
    std::vector<Bytes> found;
    for (const uint8_t byte : stream) {
        if (reader.take(byte)) {
            found.emplace_back(reader.body(), reader.body() + reader.count());
        }
    }
    return found;
}

TEST(Frame, has_the_bytes_that_the_terminal_expects) {
    // As tests/codegen/link/test_frame.py has them. CRC-32 of "123456789": 0xCBF43926.
    const Bytes body{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
    EXPECT_EQ(framed(body), (Bytes{0x0E, 0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38, 0x39, 0x26,
                                   0x39, 0xF4, 0xCB, 0x00}));
}

TEST(Frame, brings_every_body_through) {
    std::mt19937 random(1);
    FrameReader<1000> reader;
    for (size_t count = 0; count <= 1000; ++count) {
        Bytes body(count);
        for (uint8_t& byte : body)
            byte = static_cast<uint8_t>(random() % (count % 3 == 0 ? 2U : 256U));
        const Bytes frame = framed(body);
        ASSERT_LE(frame.size(), frame_bytes(count));
        ASSERT_EQ(bodies_in(reader, frame), std::vector<Bytes>{body}) << count;
    }
}

TEST(Frame, takes_the_next_one_after_any_garbage) {
    std::mt19937 random(2);
    FrameReader<16> reader;
    for (int i = 0; i < 20'000; ++i) {
        Bytes garbage(random() % 40);
        for (uint8_t& byte : garbage) byte = static_cast<uint8_t>(random());
        for (const Bytes& body : bodies_in(reader, garbage)) ASSERT_LE(body.size(), 16U);
        reader.take(0);
        const Bytes body{1, 2, 0, 3};
        ASSERT_EQ(bodies_in(reader, framed(body)), std::vector<Bytes>{body});
    }
}

TEST(Frame, that_is_damaged_does_not_come_through) {
    const Bytes body{1, 0, 2, 3};
    const Bytes whole = framed(body);
    for (size_t at = 0; at + 1 < whole.size(); ++at) {
        for (unsigned bit = 0; bit < 8; ++bit) {
            Bytes damaged = whole;
            damaged[at] = static_cast<uint8_t>(damaged[at] ^ (1U << bit));
            FrameReader<16> reader;
            EXPECT_TRUE(bodies_in(reader, damaged).empty()) << at << " " << bit;
        }
    }
}

std::deque<uint8_t> to_link;
Bytes from_link;
size_t room = 0;

const Transport kTransport{
    .read =
        [](uint8_t* bytes, size_t most) {
            size_t count = 0;
            for (; count < most && !to_link.empty(); to_link.pop_front()) {
                bytes[count++] = to_link.front();
            }
            return count;
        },
    .write =
        [](const uint8_t* bytes, size_t count) {
            const size_t taken = count < room ? count : room;
            from_link.insert(from_link.end(), bytes, bytes + taken);
            room -= taken;
            return taken;
        },
};

TEST(Link, answers_each_request_in_turn_however_slowly_bytes_leave) {
    Link link([](const uint8_t* request, size_t count, uint8_t* body) {
        for (size_t i = 0; i < count; ++i) body[i] = static_cast<uint8_t>(request[i] + 1);
        return count;
    });
    for (const Bytes& request : {Bytes{10, 0, 5}, Bytes{20, 0, 5}}) {
        for (const uint8_t byte : framed(request)) to_link.push_back(byte);
    }
    for (int i = 0; i < 100; ++i) {
        room = 1;
        link.serve(kTransport);
    }
    FrameReader<1040> reader;
    EXPECT_EQ(bodies_in(reader, from_link), (std::vector<Bytes>{{11, 1, 6}, {21, 1, 6}}));
}

// A program of more tasks than an answer has room for; one of them is watched.
struct ManyTasks {
    struct Task {
        TaskCounters* counters;
    };
    static constexpr unsigned kCount = 45;
    std::array<TaskCounters, kCount> counters{};
    std::array<Task, kCount> rows{};
    WatchState watch{.missed = 9};
    Watched watched_row{"task", 41, nullptr, &watch, 1000, nullptr};
    const Task* tasks = rows.data();
    unsigned task_count = kCount;
    const Watched* watched = &watched_row;
    unsigned watched_count = 1;

    ManyTasks() {
        for (unsigned i = 0; i < kCount; ++i) {
            counters[i] = {i, 0, 100 * i, 0, 0, 0};
            rows[i].counters = &counters[i];
        }
    }
    auto figures_of() const {
        return [this](unsigned task) { return counters[task]; };
    }
};

TEST(Answers, bring_every_task_in_as_many_answers_as_it_takes) {
    const ManyTasks program;
    unsigned told = 0;
    for (unsigned first = 0; first < ManyTasks::kCount; first += kMaxTasksTold) {
        Bytes body(Link::kMaxAnswer);
        Writer out(body.data());
        put_tasks(out, program, 77, first, program.figures_of());
        ASSERT_LE(out.count(), body.size());
        for (size_t at = 10; at < out.count(); at += 28, ++told) {
            std::array<uint32_t, 7> row{};
            std::memcpy(row.data(), body.data() + at, sizeof row);
            EXPECT_EQ(
                row, (std::array<uint32_t, 7>{told, 0, 100 * told, 0, 0, 0, told == 41 ? 9U : 0U}));
        }
    }
    EXPECT_EQ(told, ManyTasks::kCount);
}

// A task that comes between two loads, and counts to its end before the reader goes on.
TEST(Answers, tell_figures_of_one_activation) {
    for (unsigned comes_at = 1; comes_at <= 7; ++comes_at) {
        TaskCounters counters{1, 1, 1, 1, 1, 1};
        unsigned loads = 0;
        const TaskCounters told = figures_below_tasks(counters, [&](const uint32_t& counter) {
            if (++loads == comes_at) counters = {2, 2, 2, 2, 2, 2};
            return counter;
        });
        const uint32_t count = told.activations;
        EXPECT_TRUE(told.lost_samples == count && told.ticks == count && told.last_ticks == count &&
                    told.most_ticks == count && told.latest_us == count)
            << "came at load " << comes_at;
    }
}

TEST(Answers, come_to_an_end_however_often_a_task_comes_in_between) {
    TaskCounters counters;
    const TaskCounters told = figures_below_tasks(counters, [&](const uint32_t& counter) {
        counters.activations += 1;
        return counter;
    });
    EXPECT_NE(told.activations, 0U);
}

TEST(Answers, say_nothing_of_tasks_that_there_are_not) {
    const ManyTasks program;
    for (const unsigned first : {ManyTasks::kCount, 65'535U}) {
        Bytes body(Link::kMaxAnswer);
        Writer out(body.data());
        put_tasks(out, program, 77, first, program.figures_of());
        EXPECT_EQ(out.count(), 10U);
    }
}

}  // namespace
