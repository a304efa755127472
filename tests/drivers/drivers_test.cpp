// Drivers of simulated devices and of host storage.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "imu_sim.hpp"
#include "mocap_sim.hpp"
#include "motor_sim.hpp"
#include "stator/testing.hpp"
#include "storage_file.hpp"

namespace stator {
namespace {

using testing::Probe;

TEST(ImuSim, publishes_the_sample_of_its_device) {
    ImuSim::Device device{
        .timestamp_sample = 900, .gyro_B = {1.0f, 2.0f, 3.0f}, .accel_B = {4.0f, 5.0f, 6.0f}};
    ImuSim driver(device);
    ImuPorts ports{.now = 1000};
    ports.fired.data_ready = true;
    Probe accel(ports.accel, ports.now);
    Probe gyro(ports.gyro, ports.now);
    driver.step(ports);
    EXPECT_EQ(accel.newest().timestamp, 1000U);
    EXPECT_EQ(accel.newest().timestamp_sample, 900U);
    EXPECT_EQ(accel.newest().xyz, device.accel_B);
    EXPECT_EQ(gyro.newest().timestamp_sample, 900U);
    EXPECT_EQ(gyro.newest().xyz, device.gyro_B);
}

TEST(ImuSim, publishes_nothing_without_its_line) {
    ImuSim::Device device;
    ImuSim driver(device);
    ImuPorts ports{.now = 1000};
    Probe accel(ports.accel, ports.now);
    Probe gyro(ports.gyro, ports.now);
    driver.step(ports);
    EXPECT_EQ(accel.count() + gyro.count(), 0U);
}

TEST(MocapSim, publishes_heading_as_a_level_attitude) {
    MocapSim::Device device{
        .timestamp_sample = 5000, .position_N = {1.0f, -2.0f, 3.0f}, .yaw = -2.0f};
    MocapSim driver(device);
    MocapPorts ports{.now = 10000};
    ports.fired.received = true;
    Probe odometry(ports.odometry, ports.now);
    driver.step(ports);
    EXPECT_EQ(odometry.newest().timestamp_sample, 5000U);
    EXPECT_EQ(odometry.newest().position, device.position_N);
    // cos(-1), sin(-1) from a table.
    EXPECT_NEAR(odometry.newest().q[0], 0.540302f, 1e-6f);
    EXPECT_EQ(odometry.newest().q[1], 0.0f);
    EXPECT_EQ(odometry.newest().q[2], 0.0f);
    EXPECT_NEAR(odometry.newest().q[3], -0.841471f, 1e-6f);
}

TEST(MocapSim, publishes_nothing_without_its_line) {
    MocapSim::Device device;
    MocapSim driver(device);
    MocapPorts ports{.now = 10000};
    Probe odometry(ports.odometry, ports.now);
    driver.step(ports);
    EXPECT_EQ(odometry.count(), 0U);
}

int writes = 0;
MotorSim::Control written{};
void keep(const MotorSim::Control& control) {
    ++writes;
    written = control;
}

TEST(MotorSim, hands_each_command_over) {
    MotorSim::Device device{.write = keep};
    MotorSim driver(device);
    ActuatorMotors command{};
    command.control.fill(std::numeric_limits<float>::quiet_NaN());
    command.control[2] = 0.25f;
    MotorPorts ports{.now = 1000, .command = Input(command)};
    writes = 0;
    driver.step(ports);
    EXPECT_EQ(writes, 1);
    EXPECT_EQ(written[2], 0.25f);
    EXPECT_NE(written[3], written[3]);  // not a number
}

TEST(MotorSim, does_nothing_without_command_or_board) {
    MotorSim::Device connected{.write = keep};
    MotorPorts empty{.now = 1000};
    writes = 0;
    MotorSim(connected).step(empty);
    EXPECT_EQ(writes, 0);
    MotorSim::Device unconnected;
    const ActuatorMotors command{};
    MotorPorts ports{.now = 1000, .command = Input(command)};
    MotorSim(unconnected).step(ports);
}

LogBlock block_of(const char* text) {
    LogBlock block{};
    block.length = static_cast<uint32_t>(std::strlen(text));
    std::memcpy(block.data.data(), text, block.length);
    return block;
}

void store(StorageFile& driver, const LogBlock& block) {
    StoragePorts ports{.now = 1000, .block = Input(block)};
    driver.step(ports);
}

TEST(StorageFile, appends_blocks_in_order) {
    StorageFile::Device device{.file = std::tmpfile()};
    ASSERT_NE(device.file, nullptr);
    StorageFile driver(device);
    store(driver, block_of("flight"));
    store(driver, block_of(""));
    store(driver, block_of(" log"));
    std::rewind(device.file);
    std::array<char, 32> text{};
    EXPECT_EQ(std::fread(text.data(), 1, text.size(), device.file), 10U);
    EXPECT_STREQ(text.data(), "flight log");
    EXPECT_EQ(device.bytes_written, 10U);
    EXPECT_EQ(device.errors, 0U);
    EXPECT_EQ(std::fclose(device.file), 0);
}

TEST(StorageFile, writes_no_more_than_a_block_holds) {
    StorageFile::Device device{.file = std::tmpfile()};
    ASSERT_NE(device.file, nullptr);
    StorageFile driver(device);
    LogBlock block{};
    block.length = 0xffffffff;
    store(driver, block);
    EXPECT_EQ(device.bytes_written, block.data.size());
    EXPECT_EQ(std::fclose(device.file), 0);
}

TEST(StorageFile, counts_what_it_could_not_write) {
    StorageFile::Device device{.file = std::fopen("/dev/null", "rb")};
    ASSERT_NE(device.file, nullptr);
    StorageFile driver(device);
    store(driver, block_of("lost"));
    EXPECT_EQ(device.errors, 1U);
    EXPECT_EQ(device.bytes_written, 0U);
    EXPECT_EQ(std::fclose(device.file), 0);
}

TEST(StorageFile, drops_blocks_without_a_file) {
    StorageFile::Device device;
    StorageFile driver(device);
    store(driver, block_of("lost"));
    EXPECT_EQ(device.bytes_written + device.errors, 0U);
}

}  // namespace
}  // namespace stator
