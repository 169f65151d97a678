// History of contacts for the next step: the forces by which they push and hold.
import package::common::{
    dispatch::{invocation, WORKGROUP}, contact::{Contact, ContactHistory}, status::frozen,
};

@group(0) @binding(2) var<storage, read>       contacts:        array<Contact>;
@group(0) @binding(3) var<storage, read_write> contact_history: array<ContactHistory>;

@compute @workgroup_size(WORKGROUP)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = invocation(id, groups);
    if (i >= arrayLength(&contacts)) | frozen() { return; }
    contact_history[i] = ContactHistory(contacts[i].friction, max(contacts[i].force, 0.0));
}
