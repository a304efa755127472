// Lines of file descriptors: when their task runs, and what it costs to have one that is broken.
#include <fcntl.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "program.hpp"

namespace stator {
namespace {

using testing::jobs;
using testing::line;
using testing::line_fired;
using testing::line_state;
using testing::wait_for;

class LineTest : public ::testing::Test {
  protected:
    ~LineTest() override { EXPECT_TRUE(!started_ || finish()); }
    void begin() {
        ASSERT_TRUE(testing::start_unhurried());
        started_ = true;
    }

    std::atomic<unsigned> activations{0};
    std::atomic<unsigned> bytes{0};

    // Reads at most one byte in each activation.
    void read_bytes_of(int fd) {
        jobs[2] = [this, fd] {
            if (!line_fired()) return;
            ++activations;
            char byte = 0;
            if (read(fd, &byte, 1) == 1) ++bytes;
        };
    }

  private:
    bool started_ = false;
};

TEST_F(LineTest, what_is_ready_before_the_start_raises_the_line) {
    const int event = eventfd(1, EFD_NONBLOCK);
    ASSERT_TRUE(line.watch(event));
    jobs[2] = [&] {
        uint64_t value = 0;
        if (line_fired() && read(event, &value, sizeof value) == sizeof value) ++activations;
    };
    begin();
    EXPECT_TRUE(wait_for([this] { return activations == 1; }));
    eventfd_write(event, 1);
    EXPECT_TRUE(wait_for([this] { return activations == 2; }));
    EXPECT_TRUE(wait_for([] { return line.is_served(); }));
    EXPECT_EQ(line_state.early, 0U);
}

TEST_F(LineTest, the_line_comes_again_until_all_is_read) {
    int pair[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, pair), 0);
    read_bytes_of(pair[0]);
    begin();
    ASSERT_TRUE(line.watch(pair[0]));
    for (int i = 0; i < 5; ++i) ASSERT_EQ(write(pair[1], "x", 1), 1);
    EXPECT_TRUE(wait_for([this] { return bytes == 5; }));
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    EXPECT_EQ(activations, 5U) << "none in vain";
}

TEST_F(LineTest, a_timer_of_the_kernel_is_a_line) {
    const int timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK);
    const itimerspec each_ms{{0, 1'000'000}, {0, 1'000'000}};
    ASSERT_EQ(timerfd_settime(timer, 0, &each_ms, nullptr), 0);
    ASSERT_TRUE(line.watch(timer));
    std::atomic<uint64_t> expirations{0};
    jobs[2] = [&] {
        uint64_t count = 0;
        if (line_fired() && read(timer, &count, sizeof count) == sizeof count) expirations += count;
    };
    begin();
    EXPECT_TRUE(wait_for([&] { return expirations >= 20; }));
}

// What is refused as too early is not lost: the descriptor is still ready when its time has come.
TEST_F(LineTest, early_events_wait) {
    int pair[2];
    ASSERT_EQ(socketpair(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0, pair), 0);
    testing::least_between_us = 20'000;
    read_bytes_of(pair[0]);
    begin();
    ASSERT_TRUE(line.watch(pair[0]));
    for (int i = 0; i < 8; ++i) ASSERT_EQ(write(pair[1], "x", 1), 1);
    EXPECT_TRUE(wait_for([this] { return bytes == 8; }));
    ASSERT_TRUE(wait_until_idle(testing::kForever_us));
    EXPECT_GE(line_state.dropped, 2U);
    // Two that come early in a row: the second one waits.
    EXPECT_LE(activations, 2 + 2 * clock_us() / testing::least_between_us);
}

TEST_F(LineTest, a_broken_descriptor_does_not_keep_the_machine_busy) {
    int pair[2];
    ASSERT_EQ(pipe2(pair, O_NONBLOCK), 0);
    ASSERT_TRUE(line.watch(pair[0]));
    read_bytes_of(pair[0]);
    close(pair[1]);
    begin();
    EXPECT_TRUE(wait_for([this] { return activations >= 5; }));
    EXPECT_LE(activations, 2 + clock_us() / 10'000);
}

// As when an interface goes away and comes back: the driver itself changes what it waits for.
TEST_F(LineTest, a_driver_exchanges_its_descriptor) {
    int old_pipe[2];
    int new_pipe[2];
    ASSERT_EQ(pipe2(old_pipe, O_NONBLOCK) + pipe2(new_pipe, O_NONBLOCK), 0);
    ASSERT_TRUE(line.watch(old_pipe[0]));
    std::atomic<bool> exchanged{false};
    jobs[2] = [&] {
        if (!line_fired()) return;
        ++activations;
        char byte = 0;
        const int from = exchanged ? new_pipe[0] : old_pipe[0];
        const ssize_t count = read(from, &byte, 1);
        if (count == 1) ++bytes;
        if (count != 0 || exchanged) return;
        line.unwatch();  // the other end is gone
        close(old_pipe[0]);
        EXPECT_TRUE(line.watch(new_pipe[0]));
        exchanged = true;
    };
    begin();
    ASSERT_EQ(write(old_pipe[1], "x", 1), 1);
    EXPECT_TRUE(wait_for([this] { return bytes == 1; }));
    close(old_pipe[1]);
    EXPECT_TRUE(wait_for([&] { return exchanged.load(); }));
    ASSERT_EQ(write(new_pipe[1], "xx", 2), 2);
    EXPECT_TRUE(wait_for([this] { return bytes == 3; }));
}

TEST_F(LineTest, a_file_cannot_be_waited_for) {
    std::FILE* file = std::tmpfile();
    EXPECT_FALSE(line.watch(fileno(file)));
    EXPECT_EQ(errno, EPERM);
    std::fclose(file);
}

}  // namespace
}  // namespace stator
