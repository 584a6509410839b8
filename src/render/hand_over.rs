//! Work on two things at a time where the processor draws. In: a pass that is being recorded. Out: the same pass in parts.

/// Hands what a pass has got so far over to be filled in, where the processor draws: Mesa's llvmpipe works out all corners
/// of a pass on one core and fills its triangles on all of them when the pass ends or a stamp within it is asked for,
/// and then works out the next corners meanwhile. (A pass of its own would not do: it begins when the one before is done.)
#[derive(Debug)]
pub struct HandOver(Option<wgpu::QuerySet>);

impl HandOver {
    /// Most times in a pass.
    const MOST: u32 = 8;

    /// Does nothing unless the processor draws (`software`) and stamps within passes are to be had.
    pub fn new(device: &wgpu::Device, software: bool) -> Self {
        let able = software && device.features().contains(wgpu::Features::TIMESTAMP_QUERY_INSIDE_PASSES);
        let queries =
            wgpu::QuerySetDescriptor { label: Some("hand over"), ty: wgpu::QueryType::Timestamp, count: Self::MOST };
        Self(able.then(|| device.create_query_set(&queries)))
    }

    /// For one pass: each call hands over, eight times at the most.
    pub fn stamps(&self) -> impl FnMut(&mut wgpu::RenderPass) + '_ {
        let mut unused = 0..Self::MOST;
        move |pass| {
            if let (Some(queries), Some(next)) = (&self.0, unused.next()) {
                pass.write_timestamp(queries, next);
            }
        }
    }
}
