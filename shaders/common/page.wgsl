// Pages of the neighbour list: workgroups of clusters take turns among them.
import package::common::{params::params, dispatch::WORKGROUP};

// The place in the order of clusters of an invocation that has this place in its page.
fn of_page(place: u32) -> u32 {
    return (place / WORKGROUP * params.pages + params.page) * WORKGROUP + place % WORKGROUP;
}
