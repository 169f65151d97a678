// Pages of the neighbour list: workgroups of clusters take turns among them.
import package::common::{params::params, dispatch::WORKGROUP};

// The place in the order of clusters of an invocation that has this place in its page.
fn of_page(place: u32) -> u32 {
    return (place / WORKGROUP * params.pages + params.page) * WORKGROUP + place % WORKGROUP;
}

// The place in its page of an invocation that has this place in the order of clusters.
fn in_page(entry: u32) -> u32 {
    return entry / WORKGROUP / params.pages * WORKGROUP + entry % WORKGROUP;
}

// Of so many first workgroups those that are the page's.
fn workgroups_of_page(workgroups: u32) -> u32 {
    return (workgroups + params.pages - 1u - params.page) / params.pages;
}
