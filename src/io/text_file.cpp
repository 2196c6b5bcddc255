#include <stratus/io/text_file.h>

#include <stdexcept>

namespace stratus {

std::ifstream open_text(const std::filesystem::path& path) {
    std::ifstream file(path);
    if (!file || std::filesystem::is_directory(path))
        throw std::runtime_error(path.string() + ": cannot be read");
    return file;
}

std::string read_text(const std::filesystem::path& path) {
    std::ifstream file = open_text(path);
    std::string text;
    constexpr std::size_t step = 1 << 16;
    while (file && text.size() <= max_text) {
        const std::size_t size = text.size();
        text.resize(size + step);
        file.read(text.data() + size, static_cast<std::streamsize>(step));
        text.resize(size + static_cast<std::size_t>(file.gcount()));
    }
    if (file.bad()) throw std::runtime_error(path.string() + ": cannot be read");
    if (text.size() > max_text)
        throw std::runtime_error(path.string() + ": must have at most " + std::to_string(max_text) +
                                 " bytes, got more");
    return text;
}

bool read_line(std::istream& stream, std::string& line, std::uint64_t most) {
    using Traits = std::istream::traits_type;
    line.clear();
    const std::istream::sentry ready(stream, true);
    if (!ready) return false;
    std::streambuf& buffer = *stream.rdbuf();
    try {
        for (;;) {
            const Traits::int_type next = buffer.sbumpc();
            if (Traits::eq_int_type(next, Traits::eof())) break;
            if (next == '\n') return true;
            line += Traits::to_char_type(next);
            if (line.size() > most) return true;
        }
    } catch (const std::ios_base::failure&) {  // the buffer's, of a folder
        stream.setstate(std::ios::badbit);
        return false;
    }
    stream.setstate(line.empty() ? std::ios::eofbit | std::ios::failbit : std::ios::eofbit);
    return !line.empty();
}

}  // namespace stratus
