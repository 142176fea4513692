"""The kernel of `runs`: bytes to blocks of deflate with Huffman codes of their own, and runs of equal bytes as matches.

The loops over bytes and tokens are C++, which Warp compiles with the kernel: its arrays would make them four times as
slow. Integers only, so that every CPU writes the same bits.

A token is a literal, 0 to 255, or 256 plus the length of a run, 4 to 258: the byte at a distance before it, and
so on, that often again.
"""

# The code of Warp kernels is not Python to a type checker.
# pyright: reportInvalidTypeForm=false, reportOperatorIssue=false, reportArgumentType=false, reportCallIssue=false
# pyright: reportIndexIssue=false, reportReturnType=false

import warp as wp

# Of literals, the end of a block, and lengths.
SYMBOLS = wp.constant(286)
END = wp.constant(256)
# Bits of the longest code, and of the number of bits in a table's entry.
LONGEST, WIDTH = wp.constant(15), wp.constant(5)
# Code lengths are listed with this one for 11 to 138 zeros.
ZEROS = wp.constant(18)

_FIND = """
    const uint8_t* at = source.data + first;
    const uint8_t* const end = at + count;
    uint16_t* token = tokens.data;
    uint32_t* const tally = tallies.data;
    uint32_t* const other = tally + 515;  // in turns with the first, since equal literals follow each other
    for (int i = 0; i < 2 * 515; i++) tally[i] = 0;
    if (first == 0)  // nothing is before them
        for (int i = 0; i < distance && at < end; i++) { tally[*at]++; *token++ = *at++; }
    while (end - at >= 8) {
        uint64_t here, before;
        __builtin_memcpy(&here, at, 8);
        __builtin_memcpy(&before, at - distance, 8);
        uint64_t differ = here ^ before;
        if (differ & 0xffffffff) {
            const bool two = (differ >> 8) & 0xffffffff;  // no run begins at the second byte either
            tally[*at]++; *token++ = *at++;
            if (two) { other[*at]++; *token++ = *at++; }
            continue;
        }
        const uint8_t* const start = at;
        const uint8_t* const limit = end - at > 258 ? at + 258 : end;
        while (!differ) {
            at += 8;
            if (limit - at < 8) break;
            __builtin_memcpy(&here, at, 8);
            __builtin_memcpy(&before, at - distance, 8);
            differ = here ^ before;
        }
        if (differ) at += __builtin_ctzll(differ) >> 3;
        else while (at < limit && *at == at[-distance]) at++;
        tally[256 + (at - start)]++;
        *token++ = 256 + (at - start);
    }
    for (; at < end; at++) { tally[*at]++; *token++ = *at; }
    for (int i = 0; i < 515; i++) tally[i] += other[i];
    return token - tokens.data;
"""

_PUT = """
    const uint16_t* token = tokens.data;
    const uint32_t* const entry = table.data;
    uint8_t* at = stream.data + (place.data[0] >> 3);
    uint64_t n = place.data[0] & 7;
    uint64_t bits = *at & ((1 << n) - 1);
    int32_t i = 0;
    // The bits of two tokens, at most 21 each, and those of a byte that has begun.
    for (; i + 2 <= count; i += 2) {
        const uint64_t a = entry[token[i]], b = entry[token[i + 1]];
        bits |= (a >> 5) << n; n += a & 31;
        bits |= (b >> 5) << n; n += b & 31;
        __builtin_memcpy(at, &bits, 8);
        at += n >> 3; bits >>= n & 56; n &= 7;
    }
    for (; i < count; i++) {
        const uint64_t a = entry[token[i]];
        bits |= (a >> 5) << n; n += a & 31;
        __builtin_memcpy(at, &bits, 8);
        at += n >> 3; bits >>= n & 56; n &= 7;
    }
    place.data[0] = (at - stream.data) * 8 + n;
"""

# The sums over each part are in wide registers, and fit 32 bits.
_SUM = """
    const uint8_t* at = source.data + first;
    uint64_t low = sum & 0xffff, high = sum >> 16;
    for (int64_t left = count; left > 0;) {
        const uint32_t part = left < 4096 ? left : 4096;
        uint32_t once = 0, weighted = 0;
        for (uint32_t i = 0; i < part; i++) { once += at[i]; weighted += (part - i) * at[i]; }
        high = (high + low * part + weighted) % 65521;
        low = (low + once) % 65521;
        at += part; left -= part;
    }
    return high << 16 | low;
"""


@wp.func_native(_SUM)
def adler_32(sum: wp.uint32, source: wp.array(dtype=wp.uint8), first: wp.int64, count: wp.int64) -> wp.uint32:
    """Return the Adler-32 of what `sum` is of and a part of the source."""


@wp.func_native(_FIND)
def find_tokens(
    source: wp.array(dtype=wp.uint8),
    first: wp.int64,
    count: wp.int64,
    distance: wp.int32,
    tokens: wp.array(dtype=wp.uint16),
    tallies: wp.array(dtype=wp.uint32),  # in the first 515 how often each token occurs
) -> wp.int32:
    """Write the tokens of a part of the source, count them by kind, and return their number."""


@wp.func_native(_PUT)
def put_tokens(
    tokens: wp.array(dtype=wp.uint16),
    count: wp.int32,
    table: wp.array(dtype=wp.uint32),  # by token: its bits, above the number of them in the lowest 5 bits
    stream: wp.array(dtype=wp.uint8),  # with 8 bytes to spare
    place: wp.array(dtype=wp.int64),  # number of bits that are written
):
    """Append the bits of tokens."""


@wp.func
def put(bits: wp.uint32, count: int, stream: wp.array(dtype=wp.uint8), place: wp.array(dtype=wp.int64)):
    for i in range(count):
        at = int(place[0] >> wp.int64(3))
        bit = ((bits >> wp.uint32(i)) & wp.uint32(1)) << wp.uint32(place[0] & wp.int64(7))
        before = wp.uint32(0)
        if place[0] & wp.int64(7):
            before = wp.uint32(stream[at])
        stream[at] = wp.uint8(before | bit)
        place[0] = place[0] + wp.int64(1)


@wp.func
def sort_by_weight(weights: wp.array(dtype=wp.uint32), order: wp.array(dtype=wp.int32)):
    """Sort the symbols in `order`, which is nearly sorted where blocks resemble each other."""
    for i in range(1, SYMBOLS):
        symbol = order[i]
        weight = weights[symbol]
        k = int(i)
        while k > 0 and weights[order[k - 1]] > weight:
            order[k] = order[k - 1]
            k -= 1
        order[k] = symbol


@wp.func
def set_code_lengths(
    weights: wp.array(dtype=wp.uint32),  # 2 SYMBOLS: of symbols, and room for those of inner nodes
    order: wp.array(dtype=wp.int32),
    parents: wp.array(dtype=wp.int32),  # 2 SYMBOLS
    lengths: wp.array(dtype=wp.int32),
    of_length: wp.array(dtype=wp.int32),  # 2 SYMBOLS: number of codes
):
    """Set the lengths of Huffman codes, 0 for symbols that do not occur; no code is longer than LONGEST.

    Source: A. Moffat, "Huffman Coding" (2019), section 2.3: of sorted weights, with a queue of leaves and one of nodes.
    """
    sort_by_weight(weights, order)
    leaf = int(0)
    while weights[order[leaf]] == wp.uint32(0):
        lengths[order[leaf]] = 0
        leaf += 1
    first = int(leaf)
    node = int(SYMBOLS)
    free = int(SYMBOLS)
    while free - SYMBOLS < SYMBOLS - 1 - first:
        total = wp.uint32(0)
        for _ in range(2):
            if leaf < SYMBOLS and (node == free or weights[order[leaf]] <= weights[node]):
                total += weights[order[leaf]]
                parents[order[leaf]] = free
                leaf += 1
            else:
                total += weights[node]
                parents[node] = free
                node += 1
        weights[free] = total
        free += 1

    # Depths of nodes, in the place of their weights, and how many leaves each has.
    for i in range(SYMBOLS):
        of_length[i] = 0
    weights[free - 1] = wp.uint32(0)
    for i in range(free - 1 - SYMBOLS):
        inner = free - 2 - i
        weights[inner] = weights[parents[inner]] + wp.uint32(1)
    for i in range(first, SYMBOLS):
        depth = wp.min(int(weights[parents[order[i]]]) + 1, LONGEST)
        of_length[depth] = of_length[depth] + 1

    # Codes that were cut need more room than there is: longer ones instead of the longest shorter one.
    room = int(0)
    for depth in range(1, LONGEST + 1):
        room += of_length[depth] << (LONGEST - depth)
    while room > (1 << LONGEST):
        depth = int(LONGEST - 1)
        while of_length[depth] == 0:
            depth -= 1
        of_length[depth] = of_length[depth] - 1
        of_length[depth + 1] = of_length[depth + 1] + 2
        of_length[LONGEST] = of_length[LONGEST] - 1
        room -= 1

    place = int(first)
    for i in range(LONGEST):
        depth = LONGEST - i
        for _ in range(of_length[depth]):
            lengths[order[place]] = depth
            place += 1


@wp.func
def set_codes(lengths: wp.array(dtype=wp.int32), of_length: wp.array(dtype=wp.int32), codes: wp.array(dtype=wp.uint32)):
    """Set the canonical codes, their first bit lowest."""
    code = int(0)
    of_length[0] = 0
    for depth in range(1, LONGEST + 1):
        code = code << 1
        for symbol in range(SYMBOLS):
            if lengths[symbol] == depth:
                bits = wp.uint32(0)
                for i in range(depth):
                    bits = bits | (wp.uint32((code >> i) & 1) << wp.uint32(depth - 1 - i))
                codes[symbol] = bits
                code += 1


@wp.func
def put_head(
    is_last: wp.bool,
    lengths: wp.array(dtype=wp.int32),
    list_codes: wp.array(dtype=wp.uint32),
    head: wp.array(dtype=wp.uint32),
    distance: int,
    stream: wp.array(dtype=wp.uint8),
    place: wp.array(dtype=wp.int64),
):
    """Append the head of a block with dynamic codes: its kind, and the lengths of its codes."""
    put(wp.where(is_last, wp.uint32(1), wp.uint32(0)), 1, stream, place)
    for i in range(head.shape[0]):
        put(head[i] >> wp.uint32(WIDTH), int(head[i] & wp.uint32(31)), stream, place)
    symbol = int(0)
    while symbol < SYMBOLS:
        zeros = int(0)
        while symbol + zeros < SYMBOLS and zeros < 138 and lengths[symbol + zeros] == 0:
            zeros += 1
        listed = lengths[symbol]
        if zeros >= 11:
            listed = ZEROS
        put(list_codes[listed] >> wp.uint32(WIDTH), int(list_codes[listed] & wp.uint32(31)), stream, place)
        if zeros >= 11:
            put(wp.uint32(zeros - 11), 7, stream, place)
            symbol += zeros
        else:
            symbol += 1
    # One code of distances, of one bit; the first four are of one distance each.
    for _ in range(distance - 1):
        put(list_codes[0] >> wp.uint32(WIDTH), int(list_codes[0] & wp.uint32(31)), stream, place)
    put(list_codes[1] >> wp.uint32(WIDTH), int(list_codes[1] & wp.uint32(31)), stream, place)


@wp.kernel(enable_backward=False)
def deflate_runs(
    source: wp.array(dtype=wp.uint8),
    block: wp.int64,  # bytes of the source in a block
    run_symbols: wp.array(dtype=wp.int32),  # by length: its symbol
    run_extra: wp.array(dtype=wp.uint32),  # by length: the bits behind its code, above the number of them
    list_codes: wp.array(dtype=wp.uint32),  # codes of the lengths of codes
    distance: int,  # of matches, 1 to 4
    head: wp.array(dtype=wp.uint32),  # what each block begins with
    # scratch
    tokens: wp.array(dtype=wp.uint16),
    tallies: wp.array(dtype=wp.uint32),
    numbers: wp.array2d(dtype=wp.int32),  # (4, 2 SYMBOLS)
    sums: wp.array2d(dtype=wp.uint32),  # (2, 2 SYMBOLS)
    table: wp.array(dtype=wp.uint32),
    # out
    stream: wp.array(dtype=wp.uint8),
    place: wp.array(dtype=wp.int64),  # number of its bits, and the Adler-32 of the source
):
    """Write all blocks, one after the other: launched with one thread."""
    order, parents, lengths, of_length = numbers[0], numbers[1], numbers[2], numbers[3]
    weights, codes = sums[0], sums[1]
    for symbol in range(SYMBOLS):
        order[symbol] = symbol
    size = wp.int64(source.shape[0])
    first = wp.int64(0)
    place[0] = first
    sum = wp.uint32(1)
    while first < size:
        # what occurs, and how often
        part = wp.min(block, size - first)
        sum = adler_32(sum, source, first, part)
        count = find_tokens(source, first, part, distance, tokens, tallies)
        for symbol in range(SYMBOLS):
            weights[symbol] = wp.uint32(0)
            if symbol < END:
                weights[symbol] = tallies[symbol]
        weights[END] = wp.uint32(1)
        for length in range(4, 259):
            weights[run_symbols[length]] = weights[run_symbols[length]] + tallies[END + length]

        # its codes
        set_code_lengths(weights, order, parents, lengths, of_length)
        set_codes(lengths, of_length, codes)
        for literal in range(END):
            table[literal] = (codes[literal] << wp.uint32(WIDTH)) | wp.uint32(lengths[literal])
        for length in range(4, 259):
            symbol = run_symbols[length]
            bits = codes[symbol] | ((run_extra[length] >> wp.uint32(WIDTH)) << wp.uint32(lengths[symbol]))
            # and a zero bit for the distance
            width = wp.uint32(lengths[symbol] + 1) + (run_extra[length] & wp.uint32(31))
            table[END + length] = (bits << wp.uint32(WIDTH)) | width

        # the block
        put_head(first + block >= size, lengths, list_codes, head, distance, stream, place)
        put_tokens(tokens, count, table, stream, place)
        put(codes[END], lengths[END], stream, place)
        first += block
    place[1] = wp.int64(sum)
