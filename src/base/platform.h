#pragma once
// Everything that is tied to an operating system. platform_posix.cpp is the only implementation so far; another system adds a
// file beside it and nothing else changes.
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

namespace parhelion::platform {

// Ctrl-C and SIGTERM set a flag instead of ending the process; long work polls it. The second signal ends the process at once.
void install_interrupt_handlers();
enum class Interrupt { None, Interrupted, Terminated };
Interrupt interrupt_requested();
void set_interrupt(Interrupt value);  // tests, embedding programs

bool is_terminal(int file_descriptor);  // 1 stdout, 2 stderr
unsigned terminal_width();
uint64_t process_id();
bool process_exists(uint64_t process);
uint64_t resident_bytes();  // memory this process holds now
uint64_t peak_resident_bytes();
uint64_t physical_bytes();  // memory of this machine
std::filesystem::path cache_folder();  // PARHELION_CACHE_DIR, else the user's cache folder / parhelion

// Opens a file for reading without ever waiting (opening a pipe waits for its other end) and says what was opened: the name may have
// stood for something else a moment ago. Nothing but a regular file is meant to be read.
enum class FileKind { Regular, Folder, Other };
struct OpenedFile {
    std::FILE* file = nullptr;  // null: errno says why
    FileKind kind = FileKind::Other;
    uint64_t size = 0;  // bytes
};
OpenedFile open_for_reading(const std::filesystem::path& path);

// Flushes a file's data to the disk; false if that failed (disk full shows up here).
bool sync_file(const std::filesystem::path& path);

// Becomes another program, with these words as its arguments. Returns only if that failed, with why.
std::string become_program(const std::filesystem::path& program, const std::vector<std::string>& words);
std::filesystem::path program_folder();  // where this program lies; empty: unknown

// Runs a line of the system's shell and waits for its end; `output` is what it said on both streams, its first 64 KiB.
struct CommandResult {
    int exit_code = -1;  // -1: it could not be started, or was ended by a signal
    std::string output;
};
CommandResult run_command(const std::string& line);

// A shared library loaded at run time; nullptr if it is not there.
void* load_library(const std::string& name);
void* library_symbol(void* library, const char* name);

}  // namespace parhelion::platform
