// A row of cells along x in the counting sort.

struct Row {
    entries: u32,    // of the row; at last of all rows before it
    clusters: u32,   // that its entries make, eight by eight; at last of all rows before it
}
